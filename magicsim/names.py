"""Names of packages that are loaded when they are first used, and modules that scripts may know under an earlier name.

Importing a module by its earlier name gives what stands in its present place, with a `DeprecationWarning`.
"""

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType

MOVED = {
    "magicsim.deform.durometer": "magicsim.deform.indentation.durometer",
    "magicsim.deform.press": "magicsim.deform.indentation.press",
    "magicsim.episode": "magicsim.simulation.episode",
    "magicsim.geometry.export": "magicsim.geometry.files.export",
    "magicsim.plan": "magicsim.simulation.plan",
    "magicsim.scenes.relight": "magicsim.light.relight",
    "magicsim.sensor": "magicsim.simulation.sensor",
    "magicsim.still": "magicsim.simulation.still",
}
"""Earlier name of each documented module, and its present one."""


def lazy_names(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose names are loaded when they are first used.

    Args:
        package: Dotted name of the package.
        homes: Name that the package offers, to `module` or, where it has another name there, `module:name`.
    """

    def load(name: str) -> object:
        if name not in homes:
            msg = f"module '{package}' has no attribute '{name}'"
            raise AttributeError(msg)
        module, _, own_name = homes[name].partition(":")
        found = getattr(importlib.import_module(module), own_name or name)
        setattr(sys.modules[package], name, found)
        return found

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes})

    return load, names


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds the modules of `MOVED` and fills them with the names of the present ones."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """A module's place, for the names of `MOVED` alone."""
        return importlib.util.spec_from_loader(fullname, self) if fullname in MOVED else None

    def exec_module(self, module: ModuleType) -> None:
        """Takes over the names of the module in its present place, and says where that is."""
        present = MOVED[module.__name__]
        warnings.warn(f"{module.__name__} is {present} now", DeprecationWarning, stacklevel=2)
        names = vars(importlib.import_module(present))
        vars(module).update({name: value for name, value in names.items() if not name.startswith("__")})


def find_moved() -> None:
    """Makes the earlier names importable; further calls change nothing."""
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.append(_Finder())
