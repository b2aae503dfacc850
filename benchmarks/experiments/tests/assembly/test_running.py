"""What a run writes, from trials that were made up."""

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from magicsim.errors import ConfigError, ConvergenceError, OutputError
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.load import Hold
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim_experiments.assembly import running
from magicsim_experiments.assembly.stages import AssemblyConfig, Misalignment, timeline
from magicsim_experiments.assembly.summary import AssemblySummary
from magicsim_experiments.assembly.trial import Moment, Reader

TEXTURE = np.random.default_rng(0).integers(90, 110, (64, 48, 3), np.uint8)
STEPS = timeline(AssemblyConfig())
Run = Callable[..., AssemblySummary]


class NoGripper:
    """Stands where the gripper is built."""

    built = 0

    def __init__(self, *_: object, **__: object) -> None:
        NoGripper.built += 1
        frames = [TEXTURE] * 30
        self.references = (frames, frames)

    def release(self) -> None:
        return None


def made_up(_: object, __: object, misalignment: Misalignment, *, seed: int) -> tuple[Moment, ...]:
    moments, noise = [], np.random.default_rng(seed)
    for number, step in enumerate(STEPS):
        image = TEXTURE + noise.integers(0, 2, TEXTURE.shape, np.uint8)
        image[: 5 * number * (1 + misalignment.is_misaligned)] = 150
        moments.append(
            Moment(
                step=step, outcome=Hold.HELD, base_force_n=(0.0, -float(number), 0.0), base_torque_nmm=(0.0, 0.0, 0.0),
                normal_n=4.0, place=ObjectPlace(), limit=None, slid_mm=0.0, time_s=float(number), images=(image, image),
            )
        )  # fmt: skip
    return tuple(moments)


@pytest.fixture
def scene() -> SceneConfig:
    return load_scene("assembly")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, scene: SceneConfig) -> Run:
    """Trials of six made-up steps."""
    pytest.importorskip("skimage")
    monkeypatch.setattr(running, "Gripper", NoGripper)
    monkeypatch.setattr(running, "take_plug", lambda gripper, *_: gripper)
    monkeypatch.setattr(running, "play", made_up)
    NoGripper.built = 0

    def played(out: Path, trials: int, **options: object) -> AssemblySummary:
        return running.run_assembly(scene, out, **({"trials": trials, "seed": 1, "variant": lambda: "none"} | options))

    return played


def content(folder: Path) -> dict[str, bytes]:
    """Every file of a folder but the index and the summary, which have its name in them."""
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in files.items() if name not in {"task.json", "results.json"}}


def test_folder_holds_the_series_its_picture_and_the_frames_of_each_trial(run: Run, tmp_path: Path):
    notes: list[str] = []
    summary = run(tmp_path / "out", 6, progress=lambda _, __, note: notes.append(note))
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {
        "trials.json", "series.png", "results.json", "pictures", "episodes", "config.toml", "task.json",
    }  # fmt: skip
    assert len(list((tmp_path / "out/pictures").iterdir())) == 6
    whole = json.loads((tmp_path / "out/trials.json").read_text())
    assert len(whole["trials"]) == 6
    assert [row["stage"] for row in whole["trials"][0]["steps"]] == [step.stage.value for step in STEPS]
    assert summary.recognised["ssim"].misaligned.rate == 1
    assert summary.recognised["force label"].misaligned.rate == 0  # the same in all of them
    assert summary.dropped == summary.failed == 0
    assert summary.stages["offset"]["d second insertion"]["force label"].mean == 3
    assert len(notes) == 6


def test_run_that_was_stopped_goes_on_to_the_same_bytes(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    run(tmp_path / "whole", 5)
    stopped = iter([False, False, True])

    def killed(*arguments: object, **options: int) -> tuple[Moment, ...]:
        if next(stopped):
            raise KeyboardInterrupt
        return made_up(*arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr(running, "play", killed)
        with pytest.raises(KeyboardInterrupt):
            run(tmp_path / "part", 5)
    assert len(list((tmp_path / "part/episodes").iterdir())) == 2
    with pytest.raises(OutputError, match="holds an unfinished run of a task already; --resume goes on with it"):
        run(tmp_path / "part", 5)
    run(tmp_path / "part", 5, resume=True)
    whole, part = content(tmp_path / "whole"), content(tmp_path / "part")
    assert whole.keys() == part.keys()
    assert {name for name in whole if whole[name] != part[name]} == {"trials.json"}  # the folder's name is in it
    assert json.loads(whole["trials.json"])["trials"] == json.loads(part["trials.json"])["trials"]


def test_finished_folder_grows_and_nothing_is_built_for_what_is_there(run: Run, tmp_path: Path):
    run(tmp_path / "out", 3)
    before = content(tmp_path / "out")
    assert run(tmp_path / "out", 5, resume=True).trials == 5
    after = content(tmp_path / "out")
    assert all(after[name] == before[name] for name in before if name not in {"trials.json", "series.png"})
    built = NoGripper.built
    assert run(tmp_path / "out", 5, resume=True).trials == 5
    assert NoGripper.built == built
    with pytest.raises(OutputError, match="holds episodes up to number 4 already: it goes on with 5 or more, not 4"):
        run(tmp_path / "out", 4, resume=True)
    assert content(tmp_path / "out") == after
    with pytest.raises(OutputError, match="holds another task"):
        run(tmp_path / "out", 5, resume=True, seed=2)
    with pytest.raises(OutputError, match="holds another task"):
        run(tmp_path / "out", 5, resume=True, quality="full")


def test_trial_that_fails_is_counted_with_its_reason(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def failing(*arguments: object, **options: int) -> tuple[Moment, ...]:
        if arguments[2].kind == "angle":  # type: ignore[attr-defined]
            msg = "y_mm = 9 is not allowed"
            raise (ConfigError if len(list((tmp_path / "out/episodes").iterdir())) > 2 else ConvergenceError)(msg)
        return made_up(*arguments, **options)

    monkeypatch.setattr(running, "play", failing)
    summary = run(tmp_path / "out", 6)
    assert (summary.trials, summary.failed, summary.reasons) == (6, 2, {"y_mm = 9 is not allowed": 2})
    assert "angle" not in summary.stages
    assert summary.recognised["ssim"].misaligned.of == 2


def test_ssim_is_1_for_the_empty_image_and_falls_with_a_change():
    pytest.importorskip("skimage")
    reader = Reader.learned(NoGripper().references)
    moments = made_up(None, None, Misalignment(kind="offset"), seed=0)
    same = Moment(
        **{name: getattr(moments[0], name) for name in Moment.__dataclass_fields__ if name != "images"},
        images=reader.empty,
    )
    assert reader.read(same).ssim == pytest.approx(1)
    values = [reader.read(moment).ssim for moment in moments[:3]]
    assert all(later < earlier for earlier, later in pairwise(values))


def test_a_scene_without_a_plug_is_refused(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"object\.kind = 'sphere' is not allowed here: an assembly needs a 'plug'"):
        running.run_assembly(load_scene("grip"), tmp_path / "out", trials=1, seed=1)


@pytest.mark.parametrize("trials", [0, 1001])
def test_impossible_number_of_trials_is_refused(scene: SceneConfig, tmp_path: Path, trials: int):
    with pytest.raises(ConfigError, match=f"trials = {trials} is not allowed"):
        running.run_assembly(scene, tmp_path / "out", trials=trials, seed=1)
