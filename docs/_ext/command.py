"""The directive `command`: usage and options of commands, from the program itself."""

import re

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from magicsim.cli import entry  # noqa: F401 - registers the commands
from magicsim.cli.app import app

CALLED = re.compile(r"^(#+ )([\w -]+)\n\n```console\n[^\n]*?(?= --| \[| [A-Z]|\n)", re.MULTILINE)
"""A heading, and how the usage line below it calls the command, which depends on what runs this build."""
CONTENTS = re.compile(r"^#+ Table of Contents\n\n(?: *- .*\n)+\n", re.MULTILINE)


class Command(SphinxDirective):
    """A section for each command that it names, separated by commas."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Parses the program's own Markdown in place."""
        names = [name.strip() for name in self.arguments[0].split(",")]
        pages = [app[name].generate_docs(output_format="markdown", heading_level=2) for name in names]
        texts = [CALLED.sub(r"\1\2\n\n```console\nmagicsim \2", CONTENTS.sub("", page)) for page in pages]
        return self.parse_text_to_nodes("\n".join(texts), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Registers the directive."""
    app.add_directive("command", Command)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
