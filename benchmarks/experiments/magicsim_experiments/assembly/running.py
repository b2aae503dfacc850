"""All trials of an assembly into one folder; a run that was stopped goes on where it was."""

import importlib.metadata
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from magicsim.config.models import Config, apply_overrides, validate
from magicsim.config.ranges import check_number
from magicsim.detectors.profile import load_profile
from magicsim.errors import MagicsimError
from magicsim.light.variant import activate_variant
from magicsim.robot.gripper import Gripper
from magicsim.robot.live import MAX_SEED
from magicsim.robot.quality import find_quality
from magicsim.scenes.scene import SceneConfig
from magicsim_experiments.assembly.meeting import Contact, Jack
from magicsim_experiments.assembly.playing import play
from magicsim_experiments.assembly.stages import Misalignment, Spread, draw_misalignments, timeline
from magicsim_experiments.assembly.summary import AssemblySummary, Trial, draw_series, played_out, summarise
from magicsim_experiments.assembly.trial import (
    MASS_G,
    PROFILE,
    SPACE,
    SPEED_MM_S,
    SQUEEZE_MM,
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
from magicsim_experiments.task.growing import (
    RESULTS,
    Played,
    Progress,
    Run,
    as_json,
    as_png,
    grow,
    plain_values,
    resolved_scene,
)
from magicsim_experiments.task.settings import Positive, in_order

PREFIX = "task."
"""What settings of the task begin with; all others are the scene's."""
SPREAD = Spread()
Offset = Annotated[float, Field(ge=0, le=20)]
Angle = Annotated[float, Field(ge=0, le=30)]


class AssemblyConfig(Config):
    """One run of the assembly task; every number is assumed where nothing else is said."""

    jack: Jack = Jack()
    """The hole in the base."""
    contact: Contact = Contact()
    """Contact between plug and base."""
    mass_g: Positive = MASS_G
    """Mass of the plug [g]."""
    squeeze_mm: Annotated[float, Field(gt=0, le=4)] = SQUEEZE_MM
    """How much closer than touching the faces grip [mm]."""
    speed_mm_s: Positive = SPEED_MM_S
    """Speed of the carriage and of each finger [mm/s]."""
    before_mm: Annotated[float, Field(gt=0, le=8)] = 0.5
    """How far before the mouth the approach ends [mm]."""
    insertion_mm: Annotated[tuple[Positive, Positive], AfterValidator(in_order)] = (2.0, 4.0)
    """How far the pin would go in the first and in the second insertion if nothing gave way [mm]."""
    push_n: tuple[Positive, Positive] = (2.0, 4.0)
    """Force of the base at which the carriage stops in the first and in the second insertion [N]."""
    success_mm: Positive = 8.0
    """Depth of the pin once it is aligned [mm]."""
    offset_mm: Annotated[tuple[Offset, Offset], AfterValidator(in_order)] = SPREAD.offset_mm
    """Smallest and largest offset of a base beside the axis [mm]; published is 'above 3 mm'."""
    angle_deg: Annotated[tuple[Angle, Angle], AfterValidator(in_order)] = SPREAD.angle_deg
    """Smallest and largest angle of a base [degrees]; published are 'slight angles'."""
    aligned_mm: Offset = SPREAD.aligned_mm
    """Largest offset of a base that counts as aligned [mm]: the chamfer has to take it."""

    @model_validator(mode="after")
    def _check_success(self) -> Self:
        if self.success_mm > self.jack.depth_mm:
            raise ValueError(
                f"success_mm = {self.success_mm:g} is not allowed: must be at most {self.jack.depth_mm:g}, the depth "
                "of the jack"
            )
        return self

    def setup(self, *, references: int, samples: int) -> Setup:
        """What does not change from trial to trial."""
        first, second = zip(self.insertion_mm, self.push_n, strict=True)
        return Setup(
            jack=self.jack, contact=self.contact, mass_g=self.mass_g, squeeze_mm=self.squeeze_mm,
            timeline=timeline(before_mm=self.before_mm, insertions=(first, second), success_mm=self.success_mm),
            references=references, samples=samples, speed_mm_s=self.speed_mm_s,
        )  # fmt: skip

    @property
    def spread(self) -> Spread:
        """Ranges of the misalignments."""
        return Spread(offset_mm=self.offset_mm, angle_deg=self.angle_deg, aligned_mm=self.aligned_mm)


def split_settings(settings: Sequence[str]) -> tuple[list[str], AssemblyConfig]:
    """Settings of the scene, and the task with its own, which begin with `task.`.

    Args:
        settings: `dotted.key=value` each.
    """
    own = [each.strip()[len(PREFIX) :] for each in settings if each.strip().startswith(PREFIX)]
    others = [each for each in settings if not each.strip().startswith(PREFIX)]
    return others, validate(AssemblyConfig, apply_overrides({}, own), source="task assembly")


MOST_TRIALS, MOST_SAMPLES = 1000, 20
NOISE = 41
"""Keeps the seeds of the frames' noise apart from others."""
TRIALS, PLOT = "trials.json", "series.png"


class AssemblyPlayer:
    """Builds the gripper, lets it take the plug, and plays trials with it from there."""

    def __init__(
        self, scene: SceneConfig, *, seed: int, quality: str, samples: int = 1, shows_base: bool = True,
        config: AssemblyConfig | None = None,
    ) -> None:  # fmt: skip
        """Checks everything that a run needs before it begins.

        Args:
            seed: Of the misalignments, and of the noise of the trials' frames.
            quality: Of the sensors, see `magicsim.robot.quality`.
            shows_base: Whether the base is in the picture.

        Raises:
            ConfigError: No plug in the scene, too few references, an unknown quality, or scikit-image is missing.
        """
        self.scene, self.seed, self.quality = scene, seed, quality
        self.config = config or AssemblyConfig()
        self.plug = check_plug(scene.object)
        self.setup = self.config.setup(references=scene.references, samples=samples)
        self.shows_base = shows_base
        check_references(scene.references)
        find_quality(quality)
        structural_similarity()
        self._built: tuple[Gripper, Gripped, Reader] | None = None

    def settings(self) -> dict[str, Any]:
        """What trials depend on, with the content of every file."""
        held = {"task": self.config.model_dump()}
        held["picture"] = {"samples": self.setup.samples, "base": self.shows_base}
        content = resolved_scene(self.scene) | {"profile": asdict(load_profile(PROFILE))} | held
        settings: dict[str, Any] = plain_values({"seed": self.seed, "quality": self.quality, "resolved": content})
        return settings

    def play(self, number: int, misalignment: Misalignment) -> tuple[Trial, tuple[Moment, ...]]:
        """One trial, which does not depend on those before, and the moments at the end of its steps.

        Raises:
            MagicsimError: The fingers cannot be built, or not take the plug.
        """
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
            self._built = None


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
    stage = AssemblyPlayer(scene, seed=seed, quality=quality, samples=samples, shows_base=shows_base, config=config)
    drawn = draw_misalignments(trials, seed, stage.config.spread)

    def played(number: int) -> Played:
        trial, moments = stage.play(number, drawn[number])
        pictures = {f"pictures/{number:05d}.png": in_a_strip(moments)} if moments else {}
        return Played(values=asdict(trial), pictures=pictures)

    def concluded(found: Sequence[dict[str, Any]]) -> tuple[AssemblySummary, dict[str, bytes]]:
        kept = [Trial.read(values) for values in found]
        summary = summarise(kept, out=str(out))
        results = {
            RESULTS: as_json(asdict(summary)),
            TRIALS: as_json({"summary": asdict(summary), "trials": [asdict(trial) for trial in kept]}),
        }
        series = played_out(kept)
        return summary, results | ({PLOT: draw_series(series)} if series else {})

    run = Run(
        task="assembly", episodes=trials, order=range(trials), resume=resume, progress=progress, variant=variant,
        packages={"scikit-image": importlib.metadata.version("scikit-image")},
    )  # fmt: skip
    try:
        return grow(out, stage.settings(), run, played, concluded)
    finally:
        stage.release()


def in_a_strip(moments: Sequence[Moment]) -> bytes:
    """A PNG: the frames at the end of each step beside each other, the upper finger's above the lower one's."""
    ends = {moment.step: moment.images for moment in moments}.values()
    return as_png([np.concatenate([images[finger] for images in ends], axis=1) for finger in range(2)])
