"""How the command line shows results and progress."""
