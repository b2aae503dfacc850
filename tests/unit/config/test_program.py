"""Whatever is kept is known by what computed it: other sources are another program, whatever its version says."""

import re
import tomllib
from pathlib import Path

import pytest

from magicsim.config import program
from magicsim.config.program import changed_versions, other_code, program_key, versions
from magicsim.evaluation.take import take_key
from magicsim.kernels import package_hash
from magicsim.light.records import untouched
from magicsim.scenes.scene import load_scene

WORDS_ALONE = {"cyclopts", "filelock", "jinja2", "matplotlib", "pydantic", "rich", "threadpoolctl", "tomli-w"}
"""Dependencies that no frame, force or label is computed with."""
OLDER = {"magicsim": "0.1.0", "mitsuba": "3.9.1", "numpy": "2.2"}
"""What folders knew before sources counted."""


def test_versions_that_differ_or_that_only_one_side_knows_are_named():
    before, now = {"numpy": "2.2", "scipy": "1.17", "gone": "1"}, {"numpy": "2.3", "scipy": "1.17", "new": "1"}
    assert changed_versions(before, now) == ["gone", "new", "numpy"]
    assert other_code(versions(), versions()) is None
    assert other_code(versions(), versions() | {"numpy": "9"}) == "another version of numpy"
    assert other_code(OLDER, versions()) == "unknown code (it does not say of which sources)"


def test_versions_name_sources_renderer_compiler_and_solids():
    assert {"magicsim", "sources", "mitsuba", "drjit", "numpy", "scipy", "numba", "manifold3d"} <= versions().keys()
    assert program_key("llvm_ad_rgb") != program_key("scalar_rgb")


def test_versions_name_every_library_that_numbers_may_come_from():
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = {re.match(r"[\w-]+", each)[0] for each in project["dependencies"]}
    assert needed - set(program.LIBRARIES) == WORDS_ALONE


def test_every_source_file_counts_by_name_and_content(tmp_path: Path):
    (tmp_path / "part").mkdir()
    hashes = set()
    for name, text in (("a.py", "x = 1"), ("a.py", "x = 2"), ("part/b.py", "x = 2"), ("part/c.py", "")):
        (tmp_path / name).write_text(text)
        hashes.add(package_hash.__wrapped__(tmp_path))
    assert len(hashes) == 4


def test_take_and_untouched_sensor_of_other_sources_are_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(untouched, "_program", untouched._program.__wrapped__)
    scene, store = load_scene("pressed"), untouched.UntouchedStore(folder=tmp_path)
    before = take_key(scene), store._path("sensor")
    assert (take_key(scene), store._path("sensor")) == before
    known = versions() | {program.SOURCES: "0123456789abcdef"}
    monkeypatch.setattr(program, "versions", lambda: known)
    assert not {take_key(scene), store._path("sensor")} & set(before)
