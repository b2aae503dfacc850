"""`python -m magicsim` is the command line."""

from magicsim.cli import main

main()
