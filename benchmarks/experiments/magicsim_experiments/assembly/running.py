"""All trials of an assembly into one folder; a run that was stopped goes on where it was."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.config.named_files import file_hashes
from magicsim.config.ranges import check_number
from magicsim.detectors.profile import load_profile
from magicsim.errors import MagicsimError
from magicsim.light.variant import activate_variant
from magicsim.robot.gripper import Gripper
from magicsim.robot.live import MAX_SEED
from magicsim.robot.quality import find_quality
from magicsim.scenes.scene import SceneConfig
from magicsim_experiments.assembly.playing import play
from magicsim_experiments.assembly.stages import AssemblyConfig, Misalignment, draw_misalignments, timeline
from magicsim_experiments.assembly.summary import AssemblySummary, Trial, draw_series, played_out, summarise
from magicsim_experiments.assembly.trial import (
    PROFILE,
    SPACE,
    Gripped,
    Moment,
    Reader,
    Setup,
    base_of,
    check_plug,
    check_references,
    structural_similarity,
    take_plug,
)
from magicsim_experiments.task.growing import RESULTS, Played, Progress, as_json, as_png, grow

MOST_TRIALS, MOST_SAMPLES = 1000, 20
NOISE = 41
"""Keeps the seeds of the frames' noise apart from others."""
TRIALS, PLOT = "trials.json", "series.png"


class AssemblyPlayer:
    """Builds the gripper, lets it take the plug, and plays trials with it from there; see `run_assembly`."""

    def __init__(
        self, scene: SceneConfig, config: AssemblyConfig, *, seed: int, quality: str, samples: int, shows_base: bool
    ) -> None:
        """Checks everything that a run needs before it begins."""
        self.scene, self.config, self.seed, self.quality, self.shows_base = scene, config, seed, quality, shows_base
        self.plug = check_plug(scene.object)
        self.setup = Setup(config=config, timeline=timeline(config), references=scene.references, samples=samples)
        check_references(scene.references)
        find_quality(quality)
        structural_similarity()
        self._built: tuple[Gripper, Gripped, Reader] | None = None

    def settings(self) -> dict[str, Any]:
        """What trials depend on, with the content of every file."""
        scene, files = self.scene.model_dump(mode="json", exclude_none=True), file_hashes(self.scene.model_dump())
        content = {
            "scene": scene, **({"sha256": files} if files else {}), "profile": asdict(load_profile(PROFILE)),
            "task": self.config.model_dump(mode="json", exclude_none=True),
            "picture": {"samples": self.setup.samples, "base": self.shows_base},
        }  # fmt: skip
        return {"seed": self.seed, "quality": self.quality, "resolved": content}

    def play(self, number: int, misalignment: Misalignment) -> tuple[Trial, tuple[Moment, ...]]:
        """One trial, which does not depend on those before, and the moments at the end of its steps."""
        if self._built is None:
            body = base_of(self.plug, self.setup) if self.shows_base else None
            gripper = Gripper(self.scene, workspace=SPACE, quality=self.quality, companion=body)
            gripped = take_plug(gripper, self.plug, self.setup)
            self._built = (gripper, gripped, Reader.learned(gripped.references))
        gripper, gripped, reader = self._built
        seed = int(np.random.SeedSequence([self.seed, NOISE, number]).generate_state(1)[0] % MAX_SEED)
        try:
            moments = play(gripper, gripped, misalignment, seed=seed)
        except MagicsimError as error:
            return Trial(misalignment=misalignment, steps=(), error=str(error)), ()
        steps = tuple(reader.read(moment) for moment in moments)
        return Trial(misalignment=misalignment, steps=steps, error=""), moments

    def release(self) -> None:
        """Lets go of the sensors."""
        if self._built is not None:
            self._built[0].release()


def run_assembly(
    scene: SceneConfig, out: Path, *, trials: int, seed: int, quality: str = "control", samples: int = 1,
    shows_base: bool = True, config: AssemblyConfig | None = None, resume: bool = False,
    progress: Progress | None = None, variant: Callable[[], str] = activate_variant,
) -> AssemblySummary:  # fmt: skip
    """Plays trials, or what an earlier run left of them, and writes their folder.

    Args:
        trials: How many; a third each are beside the axis, at an angle, and aligned. A finished folder grows by more.
        seed: Of the misalignments, and of the noise of the trials' frames.
        quality: Of the sensors, see `magicsim.robot.quality`.
        samples: Pairs of frames of each stage, the last one at its end, at most 20.
        shows_base: Whether the base is in the picture.
        config: What is played; the defaults by default.
        resume: Whether to go on with the run in the folder.
        progress: Told how far it is: trials done, all of them, a note.

    Raises:
        ConfigError: A number is not allowed, the scene has no plug or too few references, or scikit-image is missing.
        OutputError: The folder is not ours, holds another task, or cannot be written.
        MagicsimError: The fingers cannot be built, or not take the plug.
    """
    check_number("trials", trials, 1, MOST_TRIALS, whole=True)
    check_number("samples", samples, 1, MOST_SAMPLES, whole=True)
    config = config or AssemblyConfig()
    stage = AssemblyPlayer(scene, config, seed=seed, quality=quality, samples=samples, shows_base=shows_base)
    drawn = draw_misalignments(trials, seed, config)

    def played(number: int) -> Played:
        trial, moments = stage.play(number, drawn[number])
        return asdict(trial), {f"pictures/{number:05d}.png": in_a_strip(moments)} if moments else {}

    def concluded(found: Sequence[dict[str, Any]]) -> tuple[AssemblySummary, dict[str, bytes]]:
        kept = [Trial.read(values) for values in found]
        summary = summarise(kept, out=str(out))
        results = {
            RESULTS: as_json(asdict(summary)),
            TRIALS: as_json({"summary": asdict(summary), "trials": [asdict(trial) for trial in kept]}),
        }
        series = played_out(kept)
        return summary, results | ({PLOT: draw_series(series)} if series else {})

    try:
        return grow(
            out, stage.settings(), played, concluded, task="assembly", episodes=trials, order=range(trials),
            resume=resume, progress=progress, variant=variant, packages=["scikit-image"],
        )  # fmt: skip
    finally:
        stage.release()


def in_a_strip(moments: Sequence[Moment]) -> bytes:
    """A PNG: the frames at the end of each step beside each other, the upper finger's above the lower one's."""
    ends = {moment.step: moment.images for moment in moments}.values()
    return as_png(np.vstack([np.hstack([images[finger] for images in ends]) for finger in range(2)]))
