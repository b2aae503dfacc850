"""The files for GitHub Actions: their shell steps run, end with the exit codes of `evaluate`, and name what fell."""

import os
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from dataset.fakes import TELLING, small_recipe
from evaluation.synthetic import PROFILE, make_suite

from magicsim.dataset.generate import generate_dataset
from magicsim.detectors.profile import save_profile
from magicsim.workers.attempt import WorkerOptions

from .pages import EXAMPLES, ROOT

SOUND = """
from magicsim.detectors import load_profile
from magicsim.evaluation.detector import ProfileDetector
class Detector(ProfileDetector):
    def __init__(self): super().__init__(load_profile("mine.toml"))
"""


def steps(name: str) -> list[str]:
    """Shell of every step."""
    text = (EXAMPLES / "ci" / name).read_text(encoding="utf-8")
    found = []
    for block, line in re.findall(r"^      - run: (?:\|\n((?:          .*\n)+)|(.+)\n)", text, re.MULTILINE):
        found.append(line or "".join(each[10:] for each in block.splitlines(keepends=True)))
    return found


def values(name: str) -> dict[str, str]:
    """The `env` of a file, without expressions."""
    text = (EXAMPLES / "ci" / name).read_text(encoding="utf-8").partition("\nenv:\n")[2].partition("jobs:")[0]
    found = re.findall(r"^  (\w+): ([^$\n]+)$", text, re.MULTILINE)
    return {key: value.partition(" #")[0].strip() for key, value in found}


def act(name: str, folder: Path, *, first: int = 0, **changed: str) -> subprocess.CompletedProcess[str]:
    """Runs the steps of a file as a runner does, from the first that is asked for to the first that fails.

    Nothing is installed.
    """
    programs = folder / "bin"
    programs.mkdir(exist_ok=True)
    for program, line in (("pip", "exit 0"), ("magicsim", f'exec "{sys.executable}" -m magicsim "$@"')):
        (programs / program).write_text(f"#!/bin/bash\n{line}\n")
        (programs / program).chmod(0o755)
    known = {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    known["MAGICSIM_FRAMES"] = str(folder / "kept")
    for step in steps(name)[first:]:
        done = subprocess.run(
            ["bash", "-e", "-c", step], cwd=folder, env=os.environ | values(name) | known | changed, text=True,
            capture_output=True, check=False,
        )  # fmt: skip
        if done.returncode:
            break
    return done


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A detector and a made-up suite whose takes are kept."""
    make_suite(tmp_path, rest_s=0.0)
    (tmp_path / "takes").rename(tmp_path / "magicsim-takes")
    save_profile(PROFILE, tmp_path / "mine.toml", comment="for the made-up sensor")
    (tmp_path / "detector.py").write_text(SOUND)
    return tmp_path


def evaluate(folder: Path, *arguments: str) -> None:
    """Judges the folder's detector."""
    line = [sys.executable, "-m", "magicsim", "evaluate", *arguments, "--detector", "detector.py:Detector"]
    subprocess.run(line, cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True, capture_output=True)


def weaken(folder: Path) -> None:
    """Puts the threshold of a touch where none is seen any more."""
    text = (folder / "mine.toml").read_text().replace("tau_g = 0.8", "tau_g = 0.5")
    (folder / "mine.toml").write_text(text)


def test_file_for_a_suite_runs_and_annotates_every_measure_that_fell(repository: Path):
    assert steps("detector.yml")[0] == 'pip install "$MAGICSIM"'
    own = {"SUITE": "tiny.toml", "BASELINE": "base.json"}
    evaluate(repository, "tiny.toml", "--save-baseline", "base.json")
    sound = act("detector.yml", repository, **own)
    assert (sound.returncode, "::error" in sound.stdout) == (0, False), sound.stderr
    weaken(repository)
    worse = act("detector.yml", repository, **own)
    assert worse.returncode == 1
    told = [line for line in worse.stdout.splitlines() if line.startswith("::error")]
    failed = list(ElementTree.parse(repository / "evaluate.xml").iter("failure"))
    assert len(told) == len(failed) >= 2
    assert any(line.startswith("::error title=regression::regression: Contact, balanced accuracy") for line in told)
    root = ElementTree.parse(repository / "evaluate.xml").getroot()
    assert root.get("failures") == str(len(failed))
    assert "Contact, Touched -> Untouched" in "".join(each.text or "" for each in failed)


def test_file_for_frames_of_ones_own_runs_and_names_p_values_and_frames(repository: Path):
    recipe = small_recipe("episodes=24", "references=6")
    generate_dataset(recipe, repository / "bench", options=WorkerOptions(workers=1), simulator=TELLING)
    missing = act("own-frames.yml", repository)
    assert (missing.returncode, "cannot read bench.json" in missing.stderr) == (2, True)
    evaluate(repository, "--on", "bench", "--save-baseline", "bench.json")
    sound = act("own-frames.yml", repository, first=-1)  # the frames are there, and are as they were
    assert sound.returncode == 0, sound.stderr
    weaken(repository)
    worse = act("own-frames.yml", repository, first=-1)
    assert worse.returncode == 1
    line = next(line for line in worse.stdout.splitlines() if line.startswith("regression: Contact, balanced accuracy"))
    assert float(line.rpartition("p = ")[2]) < 0.05
    assert re.search(r"^  episode-\d+/as-made frame 2: Contact, Touched -> Untouched$", worse.stdout, re.MULTILINE)
    assert "the verdicts changed (detector): " in worse.stdout
    assert "the frames changed" not in worse.stdout
