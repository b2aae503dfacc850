"""`magicsim evaluate` on a made-up suite whose episodes are in the cache."""

from pathlib import Path

import pytest
from evaluation.synthetic import PROFILE, make_suite

from magicsim.detectors.profiles.profile_file import save_profile

from .conftest import Shell


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """Suite, cache and profile in the current folder."""
    make_suite(tmp_path)
    (tmp_path / "takes").rename(tmp_path / "magicsim-takes")
    save_profile(PROFILE, tmp_path / "mine.toml", comment="for the made-up sensor")
    return tmp_path


OPTIONS = ("evaluate", "tiny.toml", "--profile", "mine.toml")


def test_evaluate_prints_the_contract_and_fails_on_a_regression_alone(shell: Shell, mine: Path):
    found = shell.json(*OPTIONS, "--save-baseline", "base.json")
    assert {"metrics", "regressions", "report"} <= set(found)
    assert found["regressions"] == []
    assert sorted(path.name for path in (mine / "magicsim-evaluate").iterdir()) == [
        ".magicsim.json", "config.toml", "evaluation.json", "report.html",
    ]  # fmt: skip
    again = shell.json(*OPTIONS, "--baseline", "base.json", "--seed", 4)
    assert again["regressions"] == []
    assert again["compared"]
    text = (mine / "mine.toml").read_text().replace("tau_g = 0.8", "tau_g = 0.6")
    (mine / "mine.toml").write_text(text)
    worse = shell(*OPTIONS, "--baseline", "base.json")
    assert worse.code == 1
    assert "regression: Contact, balanced accuracy" in worse.out
    assert "Contact, Touched -> Untouched" in worse.out
    assert (mine / "magicsim-evaluate" / "report.html").is_file()


def test_evaluate_takes_a_detector_from_a_file(shell: Shell, mine: Path):
    (mine / "blind.py").write_text(
        "from types import SimpleNamespace\n"
        "class Blind:\n"
        "    def fit(self, references): pass\n"
        "    def step(self, frame):\n"
        "        return SimpleNamespace(proximity='Normal', contact='Untouched', approach=0, touch=0)\n"
    )
    found = shell.json("evaluate", "tiny.toml", "--detector", "blind.py:Blind")
    assert found["detector"] == "blind.py:Blind"
    assert found["baseline"] is None
    headline = found["metrics"][found["standard"]]
    assert headline["contact_balanced_accuracy"]["value"] == 0.5
    (mine / "blind.py").write_text((mine / "blind.py").read_text().replace("'Normal'", "'Nothing'"))
    assert "unknown proximity 'Nothing'" in shell.refusal("evaluate", "tiny.toml", "--detector", "blind.py:Blind")


def test_evaluate_refuses_a_folder_of_other_files_before_any_work(shell: Shell, mine: Path):
    (mine / "out").mkdir()
    (mine / "out" / "notes.txt").write_text("mine")
    assert "holds other files" in shell.refusal(*OPTIONS, "--out", "out")
