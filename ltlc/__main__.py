"""`python -m ltlc` is the command `ltlc`."""

from ltlc.cli import main

main()
