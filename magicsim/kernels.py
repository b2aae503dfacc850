"""Compiled kernels: `kernel` is numba's `njit` with a cache on disk that no change of the package outlives.

Numba keeps machine code by the content of the kernel's own file. A kernel holds the code of those that it calls and the
constants that it reads, which stand in other files: here its code is kept by the content of the whole package too.
"""

import hashlib
import logging
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba as nb
from numba.core.caching import FunctionCache, IndexDataCacheFile

LOGGER = logging.getLogger(__name__)
PACKAGE = Path(__file__).parent


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:  # noqa: ANN401
    """Compiles a function when it is first called with arguments of a kind, or takes its code from the cache.

    Where no folder can be written it is compiled in every process; one line says so, or that numba compiles nothing.

    Args:
        options: Options of `numba.njit` but `cache`.
    """

    def compiled(function: Callable[..., Any]) -> Any:  # noqa: ANN401
        dispatcher = nb.njit(**options)(function)
        if dispatcher is function:
            _say("NUMBA_DISABLE_JIT is set: kernels are not compiled, and are hundreds of times slower")
            return function
        try:
            dispatcher._cache = _KernelCache(function)
        except RuntimeError:  # numba found no folder that it may write
            _say("no folder can be written for compiled kernels: they are compiled anew in every process")
        return dispatcher

    return compiled


@cache
def package_hash(package: Path = PACKAGE) -> str:
    """SHA-256 of every Python file below a folder, with their names, in hexadecimal digits."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(f"{path.relative_to(package).as_posix()}\0".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


class _KernelCache(FunctionCache):
    """Numba's cache of one function, whose entries count as old where any file of the package is another one."""

    def __init__(self, function: Callable[..., object]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        own = self._impl.locator.get_source_stamp()
        self._cache_file = IndexDataCacheFile(  # type: ignore[no-untyped-call]
            cache_path=self._cache_path, filename_base=self._impl.filename_base, source_stamp=(own, package_hash())
        )


@cache
def _say(line: str) -> None:
    """Once in a process."""
    LOGGER.warning(line)
