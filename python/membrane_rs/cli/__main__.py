"""`python -m membrane_rs.cli` is the command `membrane-rs`, as `python -m membrane_rs` is."""

from membrane_rs.cli import main

if __name__ == "__main__":
    main()
