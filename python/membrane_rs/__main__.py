"""`python -m membrane_rs` is the command `membrane-rs`."""

from membrane_rs.cli import main

if __name__ == "__main__":
    main()
