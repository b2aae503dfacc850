"""Docstrings are plain text: `|x|`, `*` and `x_` in them are what they look like, not markup."""

import re

from sphinx.application import Sphinx

CODE = re.compile(r"(``?.*?``?)")
MARKUP = re.compile(r"([|*]|(?<=\w)_(?!\w))")


def setup(app: Sphinx) -> dict[str, bool]:
    """Escapes markup before Google sections are read."""
    app.connect("autodoc-process-docstring", escape, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def escape(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Escapes in place, except between backquotes."""
    del app, what, name, obj, options
    for number, line in enumerate(lines):
        parts = CODE.split(line)
        lines[number] = "".join(part if part.startswith("`") else MARKUP.sub(r"\\\1", part) for part in parts)
