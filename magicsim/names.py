"""Names of packages that are loaded when they are first used, so that importing a package stays light."""

import importlib
import sys
from collections.abc import Callable, Mapping


def lazy_names(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose names are loaded when they are first used.

    Args:
        package: Dotted name of the package.
        homes: Name that the package offers, to `module` or, where it has another name there, `module:name`.
    """

    def load(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        module, _, own_name = homes[name].partition(":")
        value = getattr(importlib.import_module(module), own_name or name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes})

    return load, names
