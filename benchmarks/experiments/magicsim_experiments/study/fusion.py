"""Temporal fusion: what N reference frames in M backgrounds buy where the light drifts, flickers or stays."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from magicsim.config.models import Config, validate
from magicsim.detectors.combined import detect_all
from magicsim.detectors.frame import Frame
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.rest import fuse
from magicsim.errors import ConfigError
from magicsim.judge.curves import roc_curve
from magicsim.scenes.scene import SceneConfig
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import Column, Figure, Row, Study, StudyConfig, StudyResult, Table
from magicsim_experiments.study.stages import PiecesStage, read_pieces, read_refusals

NEAR_MM, PRESSED_MM = (0.3, 3.0), (0.3, 1.2)
"""Gaps of the frames near an object, and depths of those in contact [mm]."""
SCORED = 30
"""Untouched frames that are scored after the references, and again at the end of the wait."""
NOTES = (
    "References are the last N frames of the untouched sensor before the first scored one; late frames come after the "
    "wait, on the references of its beginning.",
    "E is the entropy of what brightens beyond all M backgrounds (TF-raw, grey levels), S the similarity of the "
    "binarised grid (TF-threshold). An area of 1: every frame with an object scores beyond every late untouched frame.",
    "Light drifts as a random wander of the LEDs of a given size and correlation time, or flickers with the mains; "
    "sizes are assumed.",
)


class Light(Config):
    """One way in which light is not steady."""

    name: str
    camera: dict[str, Any] = Field(default_factory=dict)
    """Tables of `rig.camera` that make it so, such as `led_drift = { share = 0.01, time_s = 30 }`."""


class FusionConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["fusion"]
    lights: Annotated[tuple[Light, ...], Field(min_length=1)]
    references: Annotated[tuple[Annotated[int, Field(ge=1, le=255)], ...], Field(min_length=1)] = (1, 3, 10, 30, 90)
    """Numbers N of reference frames."""
    backgrounds: Annotated[tuple[Annotated[int, Field(ge=1, le=255)], ...], Field(min_length=1)] = (1, 3, 10)
    """Numbers M of background references; those above N are left out."""
    wait_s: Annotated[float, Field(ge=0, le=600)] = 40.0
    """Time from the references to the late frames [s]."""
    repeats: Annotated[int, Field(ge=1, le=1000)] = 8
    """Episodes of each light, each with its own noise and drift."""
    camera_scale: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Size of the rendered frames in units of the rig's."""
    profile: str = "published"
    """Detector profile, of which N and M are replaced."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FusionTask:
    """One episode."""

    config: FusionConfig
    light: Light
    repeat: int


class Fusion(Study):
    """The study `fusion`."""

    settings = FusionConfig
    config: FusionConfig

    def __init__(self, config: FusionConfig) -> None:
        super().__init__(config)
        tasks = [
            FusionTask(config=config, light=light, repeat=k) for light in config.lights for k in range(config.repeats)
        ]
        self._episodes = PiecesStage(name="episodes", function=fused_episode, tasks=tasks, seconds=40.0)

    def refuse(self) -> None:
        """Refuses a coat, behind which nothing approaches, and a light that the camera does not know."""
        if self.config.design.is_opaque:
            raise ConfigError("study 'fusion' needs a design that is seen through: design.coat is opaque")
        load_profile(self.config.profile)
        for light in self.config.lights:
            episode_scene(FusionTask(config=self.config, light=light, repeat=0))

    def stages(self) -> Sequence[PiecesStage]:
        """One stage: the episodes."""
        return [self._episodes]

    def conclude(self, folder: Path) -> StudyResult:
        """Alarms and separation by light, N and M; means over episodes with their standard errors."""
        found = [json.loads(each) for each in read_pieces(folder, self._episodes) if each is not None]
        lost = read_refusals(folder, self._episodes)
        table = tuple(_means([row for part in found for row in part]))
        published = [row for row in table if (row["n"], row["m"]) == (30, 3)]
        return StudyResult(
            headline={f"{row['light']}.{name}": row[name] for row in published for name in WITH_ERRORS},
            tables=(Table(name="fusion", title="What N and M give", columns=COLUMNS, rows=table, shown=200),),
            figures=(
                _figure(table, "late_alarms", "false alarms, late"),
                _figure(table, "approach_area", "approach told from late rest"),
            ),
            facts={"Episodes": str(len(found)), "Profile": self.config.profile},
            notes=(*NOTES, *(f"Episode {number} has no frames: {why}." for number, why in lost.items())),
        )


COLUMNS = (
    Column(name="light"), Column(name="n", title="N"), Column(name="m", title="M"), Column(name="episodes"),
    Column(name="rest_entropy", title="E at rest", unit="bit"), Column(name="late_entropy", title="E late", unit="bit"),
    Column(name="near_entropy", title="E near", unit="bit"),
    Column(name="early_alarms", title="false alarms, early"), Column(name="late_alarms", title="false alarms, late"),
    Column(name="late_alarms_se", title="standard error"), Column(name="approach_area", title="area, approach"),
    Column(name="approach_area_se", title="standard error"), Column(name="touch_area", title="area, touch"),
    Column(name="touch_area_se", title="standard error"),
)  # fmt: skip
WITH_ERRORS = ("late_alarms", "approach_area", "touch_area")
MEASURES = ("rest_entropy", "late_entropy", "near_entropy", "early_alarms", *WITH_ERRORS)


def episode_scene(task: FusionTask) -> SceneConfig:
    """References, rest, a wait, rest again, an object that comes near and presses."""
    config = task.config
    rig = config.rig.model_dump()
    camera = rig["camera"]
    camera |= {name: round(camera[name] * config.camera_scale) for name in ("columns", "rows")}
    camera |= task.light.camera
    seed = int(np.random.SeedSequence([config.seed, task.repeat]).generate_state(1)[0]) >> 1
    start = 2 * SCORED + round(config.wait_s * 15)
    gaps = [*np.linspace(NEAR_MM[1], NEAR_MM[0], 8), *(-np.linspace(PRESSED_MM[0], PRESSED_MM[1], 3))]
    scene = {
        "schema_version": 1, "design": config.design, "rig": rig, "references": max(config.references),
        "frames_per_second": 15.0, "seed": seed,
        "object": {"kind": "sphere", "radius_mm": 5.0, "color": [0.85, 0.45, 0.15]},
        "keyframes": [{"frame": 0}, *({"frame": start + k, "gap_mm": float(gap)} for k, gap in enumerate(gaps))],
        "output": {"contact_mask": False, "displacements": False, "preview": False, "report": False},
    }  # fmt: skip
    return validate(SceneConfig, scene, source=f"light '{task.light.name}'")


def fused_episode(task: FusionTask) -> bytes:
    """Simulates an episode and judges it with every N and M.

    Returns:
        JSON: a list of rows, one a pair of N and M.
    """
    from magicsim.light.records.untouched import shared_states
    from magicsim.simulation.plan import plan_scene
    from magicsim.simulation.sensor import Sensor
    from magicsim.simulation.stream import stream_frames

    scene = episode_scene(task)
    references: list[Frame] = []
    early: list[Frame] = []
    late: list[Frame] = []
    near: list[Frame] = []
    pressed: list[Frame] = []
    start = scene.keyframes[1].frame
    sensor = Sensor.for_scene(scene, untouched=shared_states())
    for place, frame in enumerate(stream_frames(sensor, plan_scene(scene)), -scene.references):
        if place < 0:
            references.append(frame.image)
        elif place < SCORED:
            early.append(frame.image)
        elif start - SCORED <= place < start:
            late.append(frame.image)
        elif place >= start:
            (pressed if frame.truth.contact else near).append(frame.image)
    profile = load_profile(task.config.profile)
    rows = [
        {"light": task.light.name, "n": n, "m": m}
        | judged(references[-n:], early, late, near, pressed, profile, n=n, m=m)
        for n in task.config.references
        for m in task.config.backgrounds
        if m <= n
    ]
    return (json.dumps(rows, indent=1) + "\n").encode()


def judged(
    references: Sequence[Frame], early: Iterable[Frame], late: Iterable[Frame], near: Iterable[Frame],
    pressed: Iterable[Frame], profile: DetectorProfile, *, n: int, m: int,
) -> dict[str, float]:  # fmt: skip
    """What a number of references and backgrounds gives on the frames of an episode, see `MEASURES`."""
    chosen = replace(profile, reference_count=n, background_count=m)
    known = fuse(references, chosen)
    rest, wait, approach, touch = (detect_all(frames, known, chosen) for frames in (early, late, near, pressed))
    at_rest, later, nearer = (np.array([each.entropy for each in part]) for part in (rest, wait, approach))
    similar = [1 - each.similarity for each in (*touch, *wait)]
    return {
        "rest_entropy": float(at_rest.mean()), "late_entropy": float(later.mean()),
        "near_entropy": float(nearer.mean()), "early_alarms": float(np.mean(at_rest >= profile.tau_e)),
        "late_alarms": float(np.mean(later >= profile.tau_e)),
        "approach_area": roc_curve([*nearer, *later], [True] * len(nearer) + [False] * len(later)).area,
        "touch_area": roc_curve(similar, [True] * len(touch) + [False] * len(wait)).area,
    }  # fmt: skip


def _means(rows: Sequence[dict[str, Any]]) -> Iterable[Row]:
    """One row a light, N and M: means over episodes, and standard errors of some."""
    keys = list(dict.fromkeys((row["light"], row["n"], row["m"]) for row in rows))
    for light, n, m in keys:
        own = [row for row in rows if (row["light"], row["n"], row["m"]) == (light, n, m)]
        values = {name: [row[name] for row in own] for name in MEASURES}
        means = {name: float(np.mean(each)) for name, each in values.items()}
        errors = {
            f"{name}_se": float(np.std(values[name], ddof=1)) / float(np.sqrt(len(own))) if len(own) > 1 else None
            for name in WITH_ERRORS
        }
        yield {"light": light, "n": n, "m": m, "episodes": len(own), **means, **errors}


def _figure(table: Sequence[Row], measure: str, title: str) -> Figure:
    """A measure against N with M = 1, a curve a light."""
    series = []
    for light in dict.fromkeys(str(row["light"]) for row in table):
        own = [row for row in table if row["light"] == light and row["m"] == 1]
        values = [value for row in own if isinstance(value := row[measure], float)]
        series.append(Series(name=light, x=[float(str(row["n"])) for row in own], y=values))
    name = measure.replace("_", "-")
    svg = plot_series(
        series, x_title="reference frames N (M = 1)", y_title=title, name=name, label=f"{title} against N", log_x=True
    )
    return Figure(name=name, title=title.capitalize(), svg=svg)
