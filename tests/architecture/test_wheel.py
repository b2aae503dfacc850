"""What an installed copy holds, and that it works away from the checkout."""

import importlib.util
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from magicsim.config.presets import FOLDERS

from .source import ROOT

SOURCES = {
    "design": "geometry",
    "object": "geometry/objects",
    "scene": "scenes",
    "rig": "scenes/rigs",
    "recipe": "scenes/recipes",
    "profile": "detectors",
    "suite": "detectors/suites",
    "sweep": "geometry/sweeps",
}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m"]
    if all(importlib.util.find_spec(name) for name in ("build", "hatchling")):
        command += ["build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    else:
        command += ["pip", "wheel", "--no-deps", "--quiet", "--wheel-dir", str(folder), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return next(folder.glob("magicsim-*.whl"))


@pytest.fixture(scope="module")
def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("installed")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def run(installed: Path, code: str) -> str:
    """Runs code with the unpacked wheel first on the path, from its own folder."""
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=installed, env=environment)
    return done.stdout.strip()


def test_sources_of_the_presets_are_those_of_the_package():
    assert SOURCES == FOLDERS


@pytest.mark.parametrize("folder", SOURCES.values(), ids=SOURCES.keys())
def test_wheel_carries_every_preset(names: set[str], folder: str):
    presets = {f"magicsim/_presets/{path.relative_to(ROOT).as_posix()}" for path in (ROOT / folder).glob("*.toml")}
    assert presets
    assert presets <= names


def test_wheel_carries_every_module_and_data_file_of_the_package(names: set[str]):
    files = {path for path in (ROOT / "magicsim").rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert {path.relative_to(ROOT).as_posix() for path in files} <= names
    assert "magicsim/py.typed" in names
    assert "magicsim/report/report.html.jinja" in names


def test_wheel_carries_the_licence(names: set[str]):
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in names)


def test_wheel_carries_no_tests_benchmarks_or_caches_and_takes_no_other_name(names: set[str]):
    roots = {name.split("/")[0] for name in names}
    assert {root for root in roots if not root.endswith(".dist-info")} == {"magicsim"}
    assert not [name for name in names if "__pycache__" in name or "/tests/" in name or "benchmarks" in name]


def test_wheel_installs_the_command(wheel: Path):
    with zipfile.ZipFile(wheel) as archive:
        entry = next(name for name in archive.namelist() if name.endswith("entry_points.txt"))
        assert "magicsim = magicsim.cli:main" in archive.read(entry).decode()


def test_installed_copy_finds_its_own_presets(installed: Path):
    code = (
        "import magicsim, magicsim.config.presets as p; from magicsim.scenes.scene import load_scene; "
        "print(magicsim.__file__); print(p.preset_root()); print(load_scene('demo').frame_count); "
        "print(*(len(list((p.preset_root() / each).glob('*.toml'))) for each in p.FOLDERS.values()))"
    )
    module, root, frames, counts = run(installed, code).splitlines()
    assert Path(module).is_relative_to(installed)
    assert Path(root) == installed / "magicsim" / "_presets"
    assert int(frames) > 1
    assert counts.split() == [str(len(list((ROOT / folder).glob("*.toml")))) for folder in SOURCES.values()]


def test_installed_copy_finds_its_report_template(installed: Path):
    code = "from jinja2 import PackageLoader, Environment as E; " + (
        "print(E(loader=PackageLoader('magicsim.report', '.')).get_template('report.html.jinja').filename)"
    )
    assert Path(run(installed, code)).is_relative_to(installed)
