"""`python -m membrane_rs.cli` is the command `membrane-rs`."""

from membrane_rs.cli import main

main()
