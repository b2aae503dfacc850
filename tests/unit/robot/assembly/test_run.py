"""What a run writes, from trials that were made up."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from magicsim.robot.assembly import run
from magicsim.robot.assembly.cues import Reader
from magicsim.robot.assembly.misaligned import Misalignment
from magicsim.robot.assembly.stages import TIMELINE
from magicsim.robot.assembly.trial import Moment
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.outcome import Hold
from magicsim.scenes.scene import load_scene

TEXTURE = np.random.default_rng(0).integers(90, 110, (64, 48, 3), np.uint8)


class NoGripper:
    """Stands where the gripper is opened."""

    def __init__(self, *_: object, **__: object) -> None:
        frames = [TEXTURE] * 30
        self.references = (frames, frames)

    def __enter__(self) -> "NoGripper":
        return self

    def __exit__(self, *_: object) -> None:
        return None


def made_up(_: object, __: object, misalignment: Misalignment) -> tuple[Moment, ...]:
    moments = []
    for number, step in enumerate(TIMELINE):
        image = TEXTURE.copy()
        image[: 5 * number * (1 + misalignment.is_misaligned)] = 150
        moments.append(
            Moment(
                step=step, outcome=Hold.HELD, base_force_n=(0.0, -float(number), 0.0), base_torque_nmm=(0.0, 0.0, 0.0),
                normal_n=4.0, place=ObjectPlace(), slid_mm=0.0, images=(image, image),
            )
        )  # fmt: skip
    return tuple(moments)


def test_folder_holds_the_series_its_picture_and_frames_of_each_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("skimage")
    monkeypatch.setattr(run, "Gripper", NoGripper)
    monkeypatch.setattr(run, "take_plug", lambda gripper, *_: gripper)
    monkeypatch.setattr(run, "play", made_up)
    told: list[str] = []
    summary = run.run_assembly(load_scene("assembly"), tmp_path / "out", trials=6, seed=1, told=told.append)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"trials.json", "series.png", "offset.png", "angle.png", "aligned.png"} <= names
    whole = json.loads((tmp_path / "out" / "trials.json").read_text())
    assert len(whole["trials"]) == 6
    assert [row["stage"] for row in whole["trials"][0]["steps"]] == [step.stage.value for step in TIMELINE]
    assert summary.recognised["ssim"].misaligned.rate == 1
    assert summary.recognised["force label"].misaligned.rate == 0  # the same in all of them
    assert summary.dropped == summary.failed == 0
    assert summary.stages["offset"]["d second insertion"]["force label"].mean == 3
    assert told[0] == "trial 1 of 6, offset"


def test_ssim_is_1_for_the_empty_image_and_falls_with_a_change():
    pytest.importorskip("skimage")
    reader = Reader.learned(NoGripper().references)
    moments = made_up(None, None, Misalignment(kind="offset"))
    same = Moment(
        **{name: getattr(moments[0], name) for name in Moment.__dataclass_fields__ if name != "images"},
        images=reader.empty,
    )
    assert reader.read(same).ssim == pytest.approx(1)
    values = [reader.read(moment).ssim for moment in moments[:3]]
    assert all(later < earlier for earlier, later in pairwise(values))
