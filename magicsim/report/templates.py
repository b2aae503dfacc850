"""Templates of the pages that magicsim writes."""

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup

from magicsim.errors import visible


def page_template(name: str, *packages: str) -> Template:
    """A template and those it includes: everything is escaped, and a value that is not given is an error.

    Characters that hide or turn text around, such as bidirectional marks in a name, are spelt out.

    Args:
        name: Name of its file.
        packages: Packages beside whose modules templates lie, the first ones first.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package, ".") for package in packages]),
        autoescape=True,
        finalize=_shown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(name)


def _shown(value: object) -> object:
    return visible(value) if isinstance(value, str) and not isinstance(value, Markup) else value
