import importlib.util
import tomllib
from pathlib import Path

import pytest

from magicsim.cli import doctor
from magicsim.cli.doctor import EXTRAS, examine, optional_parts
from magicsim.light.variant import LLVM_VARIABLE, LLVM_VARIANT, SCALAR_VARIANT, find_llvm, probe_llvm

ROOT = Path(__file__).parents[3]


def pretend(monkeypatch: pytest.MonkeyPatch, library: Path | None, reason: str | None) -> None:
    monkeypatch.delenv("MAGICSIM_VARIANT", raising=False)
    monkeypatch.setattr(doctor, "find_llvm", lambda: library)
    monkeypatch.setattr(doctor, "probe_llvm", lambda _: reason)


def test_machine_with_llvm_has_no_problem_with_rendering(monkeypatch: pytest.MonkeyPatch):
    pretend(monkeypatch, Path("libLLVM.so.20"), None)
    found = examine()
    assert found.variant == LLVM_VARIANT
    assert found.llvm == "libLLVM.so.20"
    assert not any("LLVM" in problem for problem in found.problems)
    assert found.cores >= 1


def test_machine_without_llvm_is_told_how_to_get_it(monkeypatch: pytest.MonkeyPatch):
    pretend(monkeypatch, None, None)
    found = examine()
    assert found.variant == SCALAR_VARIANT
    assert found.llvm is None
    assert "no libLLVM was found" in found.problems[0]
    assert "pip install karellen-llvm-core" in found.problems[0]


def test_llvm_that_does_not_run_is_reported_with_its_reason(monkeypatch: pytest.MonkeyPatch):
    pretend(monkeypatch, Path("libLLVM.so.15"), "it aborts")
    found = examine()
    assert found.variant == SCALAR_VARIANT
    assert found.llvm is None
    assert "(it aborts)" in found.problems[0]


def test_machine_without_pardiso_is_told_how_to_get_it(monkeypatch: pytest.MonkeyPatch):
    pretend(monkeypatch, Path("libLLVM.so.20"), None)
    monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda _: None)
    found = examine()
    assert found.solver == "SuperLU"
    assert "pip install pypardiso" in found.problems[0]


def test_library_named_in_the_environment_comes_first(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(LLVM_VARIABLE, "somewhere/libLLVM.so.20")
    assert find_llvm() == Path("somewhere/libLLVM.so.20")


def test_file_that_is_not_a_library_fails_the_probe_with_a_reason(tmp_path: Path):
    (tmp_path / "libLLVM.so.99").write_text("not a library")
    reason = probe_llvm(tmp_path / "libLLVM.so.99")
    assert reason
    assert "\n" not in reason


def test_every_extra_that_a_job_needs_is_a_part_with_its_cost(monkeypatch: pytest.MonkeyPatch):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["optional-dependencies"].keys() - EXTRAS == {"test", "dev", "docs", "browser", "reference"}
    assert project["optional-dependencies"].keys() >= EXTRAS
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "foxglove" else object())
    missing = [part for part in optional_parts() if not part.installed]
    assert [(part.name, part.get) for part in missing] == [("mcap", "pip install 'magicsim[mcap]'")]
    assert all(len(part.without) > 10 for part in optional_parts())
