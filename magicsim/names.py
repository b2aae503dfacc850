"""Names of packages that are loaded when they are first used, so that importing a package stays light."""

import ast
import importlib
import pkgutil
import sys
from collections.abc import Callable, Mapping

Loader = Callable[[str], object]
Lister = Callable[[], list[str]]


def lazy_names(package: str, homes: Mapping[str, str]) -> tuple[Loader, Lister]:
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


def stub_names(package: str) -> tuple[Loader, Lister, list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package by the imports of its stub `__init__.pyi`.

    Type checkers read the same file, so that a name and its home are listed once.
    """
    imports = ast.parse(pkgutil.get_data(package, "__init__.pyi") or b"").body
    homes = {
        each.asname or each.name: f"{line.module}:{each.name}"
        for line in imports
        if isinstance(line, ast.ImportFrom)
        for each in line.names
    }
    return *lazy_names(package, homes), sorted(homes)
