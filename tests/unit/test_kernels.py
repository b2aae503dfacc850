"""Compiled kernels: code of yesterday is not used today, and no folder for it is no reason to stop."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import magicsim.kernels

INNER = "from magicsim.kernels import kernel\n\n\n@kernel()\ndef stiffness(x):\n    return {factor} * x\n"
OUTER = (
    "from magicsim.inner import stiffness\nfrom magicsim.kernels import kernel\n\n\n"
    "@kernel()\ndef force(x):\n    return stiffness(x) + 1.0\n\n\nprint(force(2.0), len(force.stats.cache_hits))\n"
)


def write_package(folder: Path, *, factor: float) -> None:
    package = folder / "magicsim"
    package.mkdir(exist_ok=True)
    (package / "__init__.py").touch()
    shutil.copy(magicsim.kernels.__file__, package / "kernels.py")
    (package / "inner.py").write_text(INNER.format(factor=factor))
    (package / "outer.py").write_text(OUTER)


def run_package(folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "magicsim.outer"]
    kept = {name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "NUMBA_CACHE_DIR"}}
    return subprocess.run(command, cwd=folder, env=kept | variables, capture_output=True, text=True, check=True)


def test_kernel_is_compiled_anew_where_one_that_it_calls_changed(tmp_path: Path):
    write_package(tmp_path, factor=1.0)
    assert run_package(tmp_path).stdout.split() == ["3.0", "0"]
    assert run_package(tmp_path).stdout.split() == ["3.0", "1"]
    write_package(tmp_path, factor=3.0)
    assert run_package(tmp_path).stdout.split() == ["7.0", "0"]


def test_kernel_is_compiled_without_a_cache_where_no_folder_can_be_written(tmp_path: Path):
    write_package(tmp_path, factor=1.0)
    locator = "numba.core.caching.UserProvidedCacheLocator"
    (tmp_path / "file").touch()
    done = run_package(tmp_path, NUMBA_CACHE_LOCATOR_CLASSES=locator, NUMBA_CACHE_DIR=str(tmp_path / "file" / "below"))
    assert done.stdout.split() == ["3.0", "0"]
    assert done.stderr.count("no folder can be written") == 1


def test_kernel_that_is_not_compiled_says_so(tmp_path: Path):
    write_package(tmp_path, factor=1.0)
    (tmp_path / "magicsim" / "outer.py").write_text(OUTER.replace(", len(force.stats.cache_hits)", ""))
    done = run_package(tmp_path, NUMBA_DISABLE_JIT="1")
    assert done.stdout == "3.0\n"
    assert done.stderr.count("NUMBA_DISABLE_JIT is set") == 1
