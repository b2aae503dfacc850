"""What other systems lack is not needed to import the program, and what has no wheel for them is not asked for."""

import os
import subprocess
import sys
import tomllib

import pytest

from magicsim.light.variant import LLVM_VARIABLE, find_llvm

from .source import ROOT, modules

packaging = pytest.importorskip("packaging.requirements")
EXTRAS = {"felupe", "ngsolve", "netgen", "flip_evaluator", "distributed"}
"""What some modules need and the tests do not install."""
OPTIONAL = {"magicsim.dataset.torch"}
"""The module that needs PyTorch."""
NO_WINDOWS = ("fcntl", "resource", "pwd", "grp", "termios", "posix_ipc")
LINUX = {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix"}
MACHINES = {
    "linux-x86_64": LINUX | {"platform_machine": "x86_64"},
    "linux-aarch64": LINUX | {"platform_machine": "aarch64"},
    "macos-arm64": {"sys_platform": "darwin", "platform_system": "Darwin", "platform_machine": "arm64"},
    "windows": {"sys_platform": "win32", "platform_system": "Windows", "platform_machine": "AMD64", "os_name": "nt"},
}
WITHOUT_WHEEL = {
    "linux-x86_64": set(),
    "linux-aarch64": {"karellen-llvm-core", "lib3mf", "pypardiso"},
    "macos-arm64": {"karellen-llvm-core", "pypardiso"},
    "windows": {"karellen-llvm-core", "pypardiso"},
}
"""Of what the program depends on, by `nox -s platforms`."""


@pytest.mark.parametrize("machine", MACHINES)
def test_nothing_without_a_wheel_is_asked_for(machine: str):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found = [packaging.Requirement(line) for line in project["dependencies"]]
    asked = {each.name for each in found if each.marker is None or each.marker.evaluate(MACHINES[machine])}
    assert not asked & WITHOUT_WHEEL[machine]
    assert {"mitsuba", "numpy", "trimesh"} <= asked


def test_every_module_imports_without_what_windows_lacks():
    names = sorted(set(modules()) - OPTIONAL - {"magicsim.__main__", "magicsim.detectors.__main__"})
    code = (
        "import importlib, os, sys\n"
        "import mitsuba, numba, scipy.optimize, matplotlib, cv2, multiprocessing.pool, filelock, av, datasets\n"
        f"sys.modules.update(dict.fromkeys({NO_WINDOWS}))\n"
        "for name in ('sysconf', 'sched_getaffinity', 'fork', 'getuid'):\n    delattr(os, name)\n"
        f"for name in {names}:\n    try:\n        importlib.import_module(name)\n"
        f"    except ModuleNotFoundError as error:\n        assert error.name.split('.')[0] in {EXTRAS}, name\n"
        "from magicsim.cli.foresight import check_memory\nfrom magicsim.scenes.scene import load_scene\n"
        "check_memory(load_scene('demo'))\n"
    )
    # The renderer, imported alone, would take the machine's libLLVM, if there is one, and not the program's own.
    own = {LLVM_VARIABLE: str(find_llvm())} if find_llvm() is not None else {}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, env=os.environ | own
    )
    assert done.returncode == 0, done.stderr[-2000:]
