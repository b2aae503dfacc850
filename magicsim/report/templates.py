"""Templates of the pages that magicsim writes."""

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, Template


def page_template(name: str, *packages: str) -> Template:
    """A template and those it includes: everything is escaped, and a value that is not given is an error.

    Args:
        name: Name of its file.
        packages: Packages beside whose modules templates lie, the first ones first.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package, ".") for package in packages]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(name)
