"""The command line. Every command takes `--json`: one object on stdout, everything else on stderr.

Heavy modules are imported inside the commands, so that `magicsim --help` answers at once.
"""

from magicsim.cli.entry import main

__all__ = ["main"]
