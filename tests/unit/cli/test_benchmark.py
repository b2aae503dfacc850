"""`magicsim evaluate` on a made-up suite whose episodes are in the cache."""

from pathlib import Path

import pytest
from dataset.fakes import FAKE, small_recipe
from evaluation.synthetic import PROFILE, make_suite

from magicsim.dataset.generate import generate_dataset
from magicsim.detectors.profile import save_profile
from magicsim.evaluation.answers import judge_footage
from magicsim.evaluation.baseline import save_baseline
from magicsim.evaluation.detector import ProfileDetector
from magicsim.evaluation.evaluate import film_suite
from magicsim.workers.attempt import WorkerOptions

from .conftest import Shell
from .small import settings


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
    assert again["cannot_judge"] is None
    standard = [each for each in again["compared"] if each["condition"] == again["standard"]]
    assert all(each["smallest_fall"] >= each["matters"] for each in standard)
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
    found = shell.json("evaluate", "tiny.toml", "--detector", "blind.py:Blind", code=1)
    assert found["detector"] == "blind.py:Blind"
    assert found["baseline"] is None
    headline = found["metrics"][found["standard"]]
    assert headline["contact_balanced_accuracy"]["value"] == 0.5
    (mine / "blind.py").write_text((mine / "blind.py").read_text().replace("'Normal'", "'Nothing'"))
    assert "unknown proximity 'Nothing'" in shell.refusal("evaluate", "tiny.toml", "--detector", "blind.py:Blind")


NEVER = (
    "from magicsim.detectors import load_profile\n"
    "from magicsim.evaluation.detector import ProfileDetector\n"
    "from dataclasses import replace\n"
    "class Sound(ProfileDetector):\n"
    "    def __init__(self): super().__init__(load_profile('mine.toml'))\n"
    "class Never(Sound):\n"
    "    def step(self, frame): return replace(super().step(frame), contact='Untouched')\n"
    "class Late(Sound):\n"
    "    said = None\n"
    "    def step(self, frame):\n"
    "        now = super().step(frame)\n"
    "        told, self.said = self.said or now, now\n"
    "        return told\n"
)


@pytest.fixture
def two_takes(tmp_path: Path) -> Path:
    """Suite of two takes, cache, profile and detectors in the current folder, with a baseline of another name."""
    suite, cache = make_suite(tmp_path, objects=2)
    cache.rename(tmp_path / "magicsim-takes")
    save_profile(PROFILE, tmp_path / "mine.toml", comment="for the made-up sensor")
    (tmp_path / "never.py").write_text(NEVER)
    films = [film for take in film_suite(suite, tmp_path / "magicsim-takes") for film in take]
    sound = [judge_footage(film, lambda: ProfileDetector(PROFILE), who="sound") for film in films]
    save_baseline(tmp_path / "base.json", sound, suite="tiny", detector="sound")
    return tmp_path


def quick(detector: str) -> tuple[str, ...]:
    return ("evaluate", "tiny.toml", "--quick", "--detector", f"never.py:{detector}", "--baseline", "base.json")


def test_detector_that_never_says_touched_fails_a_quick_evaluation_of_two_takes(shell: Shell, two_takes: Path):
    done = shell(*quick("Never"))
    assert done.code == 1
    assert "collapse: never.py:Never: Contact is never named Touched: 0 of 8 frames\n" in done.out
    assert "no regression" not in done.out
    assert "Contact is never named Touched" in (two_takes / "magicsim-evaluate" / "report.html").read_text()
    alone = shell(*quick("Never")[:-2], "--save-baseline", "never.json")
    assert alone.code == 1
    known = shell(*quick("Never")[:-1], "never.json", "--allow-weak")
    assert known.code == 0
    assert "0 of 8 frames, as of the baseline never.py:Never\n" in known.out


def test_two_shared_takes_cannot_judge_which_is_an_error_of_its_own(shell: Shell, two_takes: Path):
    for detector in ("Sound", "Late"):  # one frame late: worse, and nothing that two takes can show
        done = shell(*quick(detector))
        assert done.code == 3
        assert done.err.splitlines()[-1].startswith("magicsim: cannot judge: 2 shared takes in dark/rig, ")
        assert done.err.endswith("add takes, or give --allow-weak\n")
        assert "no regression" not in done.out
        assert "smallest falls that could be found, dark/rig: proximity none, contact none" in done.out
    allowed = shell(*quick("Sound"), "--allow-weak")
    assert allowed.code == 0
    assert "cannot judge: 2 shared takes" in allowed.out
    assert "no regression" not in allowed.out
    found = shell.json(*quick("Sound"), code=3)
    assert found["cannot_judge"].startswith("2 shared takes")
    assert found["collapses"] == []
    assert {each["smallest_fall"] for each in found["compared"]} == {None}


def test_evaluate_refuses_a_folder_of_other_files_before_any_work(shell: Shell, mine: Path):
    (mine / "out").mkdir()
    (mine / "out" / "notes.txt").write_text("mine")
    assert "holds other files" in shell.refusal(*OPTIONS, "--out", "out")


BLIND = (
    "from types import SimpleNamespace\n"
    "class Blind:\n"
    "    def fit(self, references): self.seen = len(list(references))\n"
    "    def step(self, frame):\n"
    "        return SimpleNamespace(proximity='Normal', contact='Untouched', approach=0, touch=0)\n"
)


def test_own_detector_is_judged_on_a_run_that_exists(shell: Shell, tmp_path: Path):
    (tmp_path / "blind.py").write_text(BLIND)
    path = "keyframes=[{frame=0}, {frame=1, gap_mm=1.0}, {frame=2, gap_mm=-0.4}, {frame=3, gap_mm=-0.4}]"
    off = settings("output.report=false", "output.preview=false", "output.displacements=false", path)
    assert shell("simulate", "near", "--out", "run", *off).code == 0
    found = shell.json("evaluate", "--on", "run", "--detector", "blind.py:Blind", code=1)
    assert (found["suite"], found["episodes"], found["frames"]) == ("run", 1, 4)
    assert found["confusion"]["contact"]["Contact"]["Untouched"] == 2
    assert found["confusion"]["proximity"]["Near"] == {"Normal": 1, "Approaching": 0, "Noise": 0}
    assert found["baseline"] is None
    assert found["left_out"] == []
    assert "holds no labelled frames" in shell.refusal("evaluate", "--on", str(tmp_path))
    assert "--quick is not allowed with --on" in shell.refusal("evaluate", "--on", "run", "--quick")


def test_own_detector_is_judged_on_a_dataset_that_exists(shell: Shell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    generate_dataset(small_recipe("episodes=3"), tmp_path / "set", options=WorkerOptions(workers=1), simulator=FAKE)
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "frames"))
    (tmp_path / "blind.py").write_text(BLIND)
    found = shell.json("evaluate", "--on", "set", "--detector", "blind.py:Blind")
    assert found["episodes"] == 3
    assert found["metrics"]["as-made/as-made"]["contact_balanced_accuracy"]["episodes"] >= 0


def test_quick_evaluation_says_what_it_leaves_out_and_how_long_it_takes(shell: Shell, mine: Path):
    done = shell(*OPTIONS, "--quick")
    assert done.code == 0
    assert "left out: noise high, 20 of 30 s at rest" in done.out
    found = shell.json(*OPTIONS, "--quick")
    whole = shell.json(*OPTIONS)
    assert found["episodes"] < whole["episodes"]
    assert found["standard"] == whole["standard"]
    assert next(iter(found["metrics"])) == found["standard"]
    assert whole["left_out"] == []
    assert set(found) == set(whole)


@pytest.mark.parametrize("target", ["folder", "file/base.json", "loop/base.json", "z" * 300 + ".json"])
def test_place_of_a_baseline_that_cannot_be_written_is_told_before_anything_is_judged(
    shell: Shell, tmp_path: Path, target: str
):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("mine")
    (tmp_path / "loop").symlink_to("loop")
    found = shell("evaluate", "--save-baseline", target)  # of a suite of which nothing is rendered here
    assert found.code == 2
    assert found.err.startswith("magicsim: ")
    assert found.err.count("\n") == 1
    assert target[:40] in found.err
    assert not (tmp_path / "magicsim-takes").exists()


def test_quick_evaluation_renders_nothing_of_the_suite_that_comes_with_the_program(shell: Shell, tmp_path: Path):
    done = shell("evaluate", "--quick", "--set", "design.skin_mm=0.7")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "--set design.skin_mm is not allowed with --quick" in done.err
    found = shell.json("evaluate", "--quick", "--set", "rest_s=0", "--set", "resamples=99")
    assert found["suite"] == "quick"
    assert found["episodes"] + sum(each.startswith("take ") for each in found["left_out"]) == 20
    assert found["baseline"] == "calibrated"
    assert found["provenance"]["frames_changed"] == found["provenance"]["verdicts_changed"] == []
    assert found["cannot_judge"] is None
    assert not (tmp_path / "magicsim-takes").exists()
