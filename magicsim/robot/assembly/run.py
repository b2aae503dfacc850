"""All trials of an assembly, and the folder that tells of them."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from magicsim.config.ranges import check_number
from magicsim.errors import ConvergenceError
from magicsim.folder import check_target, result_folder
from magicsim.robot.assembly.cues import Cues, Reader, check_references, structural_similarity
from magicsim.robot.assembly.misaligned import Misalignment, draw_misalignments
from magicsim.robot.assembly.recognition import CUES, Rate, Recognition, recognise, unrecognised
from magicsim.robot.assembly.stages import Stage
from magicsim.robot.assembly.trial import Moment, Setup, check_plug, play, take_plug
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig

MOST_TRIALS = 1000
SPACE = Workspace(
    x_mm=(-1.5, 1.5), y_mm=(0.0, 8.0), twist_deg=(-15.0, 15.0), tilt_x_deg=(-15.0, 15.0), tilt_y_deg=(-15.0, 15.0),
    gap_mm=(-1.5, 20.0),
)  # fmt: skip
"""Where the plug may go in the grip."""
Told = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class StageSeries:
    """What a cue is in one stage, over trials."""

    trials: int
    mean: float
    least: float
    most: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AssemblySummary:
    """What `magicsim task assembly` reports."""

    out: str
    """The folder."""
    trials: int
    failed: int
    """Trials without a valid equilibrium somewhere, left out of everything else."""
    dropped: int
    """Trials in which the plug was lost."""
    recognised: dict[str, Recognition]
    """By cue: misaligned trials that it recognises."""
    neither: Rate
    """Misaligned trials that neither SSIM nor contact detector recognises."""
    stages: dict[str, dict[str, dict[str, StageSeries]]]
    """By kind of trial, stage and cue."""


def run_assembly(
    scene: SceneConfig, out: Path, *, trials: int, seed: int, quality: str = "control", told: Told = lambda _: None
) -> AssemblySummary:
    """Plays a number of trials and writes them.

    Args:
        scene: The fingers, and a plug between them.
        out: Folder of the result: `trials.json`, `series.png`, and the frames of the first trial of each kind.
        trials: How many; a third each are beside the axis, at an angle, and aligned.
        seed: Of the misalignments.
        quality: Of the sensors, see `magicsim.robot.quality`.
        told: Told what happens.

    Raises:
        ConfigError: A number is not allowed, the scene has no plug or too few references, or scikit-image is missing.
        OutputError: The folder cannot be written.
        MagicsimError: The fingers cannot be built.
    """
    check_number("trials", trials, 1, MOST_TRIALS, whole=True)
    plug = check_plug(scene.object)
    check_references(scene.references)
    structural_similarity()
    check_target(out)
    with Gripper(scene, workspace=SPACE, quality=quality) as gripper, result_folder(out) as folder:
        gripped = take_plug(gripper, plug, Setup(references=scene.references))
        reader, played, failed = Reader.learned(gripped.references), [], 0
        shown: set[str] = set()
        for number, misalignment in enumerate(draw_misalignments(trials, seed)):
            told(f"trial {number + 1} of {trials}, {misalignment.kind}")
            try:
                moments = play(gripper, gripped, misalignment)
            except ConvergenceError as error:
                told(f"trial {number + 1} has no valid equilibrium: {error}")
                failed += 1
                continue
            played.append((misalignment, tuple(reader.read(moment) for moment in moments)))
            if misalignment.kind not in shown:
                shown.add(misalignment.kind)
                cv2.imwrite(str(folder / f"{misalignment.kind}.png"), _strip(moments)[..., ::-1])
        summary = AssemblySummary(
            out=str(out),
            trials=trials,
            failed=failed,
            dropped=sum(series[-1].stage is not Stage.OPEN for _, series in played),
            recognised=recognise(played),
            neither=unrecognised(played),
            stages=_by_stage(played),
        )
        _write(folder, played, summary)
    return summary


def _by_stage(
    played: list[tuple[Misalignment, tuple[Cues, ...]]],
) -> dict[str, dict[str, dict[str, StageSeries]]]:
    found: dict[str, dict[str, dict[str, StageSeries]]] = {}
    for kind in sorted({each.kind for each, _ in played}):
        series = [cues for each, whole in played if each.kind == kind for cues in whole]
        found[kind] = {}
        for stage in Stage:
            here = [cues for cues in series if cues.stage is stage]
            if here:
                found[kind][stage.value] = {
                    name: _series([value(cues) for cues in here]) for name, value in CUES.items()
                }
    return found


def _series(values: list[float]) -> StageSeries:
    return StageSeries(trials=len(values), mean=float(np.mean(values)), least=min(values), most=max(values))


def _strip(moments: tuple[Moment, ...]) -> Any:  # noqa: ANN401 -- an image
    rows = [np.concatenate([moment.images[finger] for moment in moments], axis=1) for finger in range(2)]
    return np.concatenate(rows)


def _write(folder: Path, played: list[tuple[Misalignment, tuple[Cues, ...]]], summary: AssemblySummary) -> None:
    rows = [
        {"misalignment": asdict(misalignment), "steps": [asdict(cues) for cues in series]}
        for misalignment, series in played
    ]
    whole = {"summary": asdict(summary), "trials": rows}
    (folder / "trials.json").write_text(json.dumps(whole, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    if played:
        from magicsim.robot.assembly.series_plot import draw_series

        draw_series(played, folder / "series.png")
