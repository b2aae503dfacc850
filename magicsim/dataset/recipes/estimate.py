"""What a dataset will cost, before any work starts: a rough model of the time, and the size of its pictures."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.camera.camera import Camera
from magicsim.camera.projection import picture_mm
from magicsim.dataset.recipes.draw import DrawnEpisode, differing_units, sensor_of
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.geometry.grid import node_spacing_mm
from magicsim.scenes.scene import RECORDED_SAMPLES, RenderSettings, SceneConfig
from magicsim.simulation.plan import plan_scene

CAMERA_S, PARTICLE_S, MOVE_S, START_S = 2.2e-6, 7e-6, 0.4, 12.0
"""Core seconds of a camera sample, a light particle, meshes that move, a process's start with its compilation; of the
default design on one x86-64 core."""
SOLVE_S = {"full": 0.6, "control": 0.25}
"""Core seconds of a solved frame at each quality."""
EPISODE_S = {"true": 1.5, "fast": 0.3}
"""Core seconds of an episode's sensor in each tier."""
LOOK_S, RECORD_S = 3e-6, 4e-6
"""Core seconds of a pixel that is seen by recorded paths, and of a camera sample that is recorded."""
FAST_S = 0.4
"""Core seconds of a touched frame in the fast tier, its frame before contact included; a near one takes a third."""
FORCE_SOLVES, WRITE_S = 2, 0.004
"""Further equilibria on the way to a force, and core seconds of a row that is encoded and written."""
COVERED = 0.93
"""Share of the face's sides from which a picture counts as one of the whole face."""
TAXEL_SHARE = 0.3
"""Bytes of compressed fields of touch over those in memory: most taxels touch nothing."""
IMAGE_BYTES, MASK_BYTES, DEPTH_BYTES, NODE_BYTES, ROW_BYTES = 2.0, 0.02, 1.0, 6.0, 3000
"""A pixel of a frame, of a mask, of a depth map in contact, a lattice node in contact, the rest of a row."""
CHOICES = (
    ("labels.displacements=false", "output", "displacements", False),
    ("labels.depth_map=false", "output", "depth_map", False),
    ("--tier fast", "render", "tier", "fast"),
    ("contact.quality=control", "contact", "quality", "control"),
)
"""What a recipe can do without, and the part and field of its scenes that this changes."""
WORTH = 0.02
"""Least share of the time or of the bytes that is told."""
LOOKED_AT, COUNTED = 64, 256
"""Most episodes that are planned, and of which the frames are counted; the rest is taken to be like them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Phase:
    """One part of the work."""

    name: str
    core_seconds: float
    """Time on one core [s]."""
    cut: str = ""
    """What would make it shorter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Time and size, roughly: within a factor of two or so."""

    frames: int
    phases: tuple[Phase, ...]
    bytes: int
    kept: tuple[int, int] = (0, 0)
    """Episodes that are finished already, and all."""
    view: str = ""
    """How much of the face the picture covers, and what share of touches it leaves out; empty where it covers all."""
    savings: tuple[str, ...] = ()
    """What each choice saves."""

    @property
    def core_seconds(self) -> float:
        """Time on one core [s]."""
        return sum(phase.core_seconds for phase in self.phases)

    @property
    def longest(self) -> Phase:
        """The phase that takes most of the time."""
        return max(self.phases, key=lambda phase: phase.core_seconds)

    def seconds(self, cores: int) -> float:
        """Time on some cores [s]."""
        return self.core_seconds / cores


def estimate(
    recipe: Recipe,
    episodes: Sequence[DrawnEpisode],
    chosen: npt.NDArray[np.int64] | None = None,
    *,
    processes: int,
) -> Cost:
    """What some of the episodes of a recipe will cost.

    All episodes are chosen by default. With fewer sensors than processes each makes the same untouched state.
    """
    numbers = np.arange(len(episodes)) if chosen is None else chosen
    planned, counted = _some(numbers, LOOKED_AT), _some(numbers, COUNTED)
    looked_at = [episodes[each] for each in planned]
    scale = len(numbers) / max(1, len(looked_at))
    costs = [episode_cost(each.scene, by_force=each.force_n is not None) for each in looked_at]
    sensors = len({sensor_of(recipe, each) for each in counted})
    if len(counted) < len(numbers):
        sensors = min(len(numbers), int(sensor_of(recipe, int(numbers[-1] - numbers[0]))) + 1)
    units = differing_units(recipe, sensors)
    anchors = min(max(processes, units), len(numbers))
    frames = round(sum(recipe.references + episodes[each].scene.frame_count for each in counted)
                   * len(numbers) / max(1, len(counted)))  # fmt: skip
    shows: dict[str, float] = {}
    for each, cost in zip(looked_at, costs, strict=True):
        target = f"frames of {each.scene.object.kind if each.scene.object is not None else 'no object'}"
        shows[target] = shows.get(target, 0.0) + scale * cost[0]
    phases = [
        Phase(name=f"{processes} processes that start", core_seconds=processes * START_S, cut="fewer --workers"),
        Phase(
            name=f"untouched images of {units} unit{'s' if units > 1 else ''}",
            core_seconds=anchors * _shared_s(recipe.render, recipe.rig.camera),
            cut="fewer units (episodes_per_sensor)" if units > 1 else "render.anchor_samples",
        ),
        *(
            Phase(name=name, core_seconds=time, cut="fewer frames of paths, their weight, or render.samples")
            for name, time in sorted(shows.items(), key=lambda item: -item[1])
        ),
        Phase(name="writing", core_seconds=frames * WRITE_S, cut="labels.depth_map and labels.displacements"),
    ]
    view = _view(recipe, [episodes[each] for each in counted])
    size = round(scale * sum(cost[1] for cost in costs))
    kept = (len(episodes) - len(numbers), len(episodes))
    whole = Cost(frames=frames, phases=tuple(phases), bytes=size, kept=kept, view=view)
    return replace(whole, savings=_savings(looked_at, costs, scale, (whole.core_seconds, size)))


def _savings(
    episodes: Sequence[DrawnEpisode], costs: Sequence[tuple[float, float]], scale: float, whole: tuple[float, float]
) -> tuple[str, ...]:
    """What each choice that a recipe has not made saves of time and bytes, by some of its episodes and their costs."""
    told = []
    for name, part, field, value in CHOICES:
        less = np.zeros(2)
        for each, cost in zip(episodes, costs, strict=True):
            settings = getattr(each.scene, part)
            if getattr(settings, field) != value:
                other = each.scene.model_copy(update={part: settings.model_copy(update={field: value})})
                less += np.subtract(cost, episode_cost(other, by_force=each.force_n is not None))
        saved = zip(scale * less / np.maximum(whole, 1e-9), ("the time", "the bytes"), strict=True)
        if words := " and ".join(f"{each:.0%} of {what}" for each, what in saved if each >= WORTH):
            told.append(f"{name} saves {words}")
    return tuple(told)


def _view(recipe: Recipe, episodes: Sequence[DrawnEpisode]) -> str:
    """What the picture leaves out of the face and of the touches on it."""
    low, high = picture_mm(recipe.design, recipe.rig.lens, recipe.rig.camera)
    size, face = high - low, np.array(recipe.design.footprint_mm)
    presses = [
        np.array([[at.x_mm, at.y_mm] for at in each.scene.keyframes if at.gap_mm is not None and at.gap_mm < 0])
        for each in episodes
        if each.path_kind == "touch"
    ]
    outside = np.array([((places < low) | (places > high)).any() for places in presses], bool)
    if (size > COVERED * face).all() and not outside.any():
        return ""
    words = [f"the picture covers {size[0]:.3g} x {size[1]:.3g} mm of a face of {face[0]:g} x {face[1]:g} mm"]
    if len(outside):
        words.append(
            f"{outside.mean():.0%} of the touches are outside of it"
            + (", for a part of their way" if recipe.inside else "")
        )
    return ": ".join(words)


def estimate_scene(scene: SceneConfig) -> Cost:
    """What one scene will cost in a process of its own."""
    seconds, size = episode_cost(scene)
    shared = _shared_s(scene.render, scene.rig.camera) + START_S
    phases = (Phase(name="start and untouched image", core_seconds=shared), Phase(name="frames", core_seconds=seconds))
    return Cost(frames=scene.references + scene.frame_count, phases=phases, bytes=round(size))


def _some(numbers: npt.NDArray[np.int64], most: int) -> list[int]:
    """Some of the numbers, evenly spread."""
    return list(map(int, numbers[:: odd_step(len(numbers), most)]))


def odd_step(count: int, most: int) -> int:
    """A step that takes no more than so many of some things; odd, as every second Sobol point lies in one half."""
    return math.ceil(count / most) | 1


def _shared_s(render: RenderSettings, camera: Camera) -> float:
    """Seconds of the untouched sensor, with its recorded paths."""
    if not render.anchor_samples:
        return 0.0
    recorded = min(render.anchor_samples, RECORDED_SAMPLES) + render.samples
    others = max(0, render.anchor_samples - RECORDED_SAMPLES)
    paths = camera.rows * camera.columns * (recorded * RECORD_S + others * CAMERA_S)
    return paths + render.anchor_particles * PARTICLE_S


def episode_cost(scene: SceneConfig, *, by_force: bool = False) -> tuple[float, float]:
    """Core seconds of an episode without the anchor, and the bytes of its rows; by force a depth is found first."""
    render, camera, plan = scene.render, scene.rig.camera, plan_scene(scene)
    pixels = camera.rows * camera.columns
    rendered = [frame for frame in plan.frames if frame.same_as is None]
    solved, anchored = sum(frame.solve for frame in plan.frames), render.anchor_samples > 0
    traced = 1 + sum(frame.solve or not anchored for frame in rendered)
    if render.tier == "fast":
        pictures = FAST_S * sum(frame.state.gap_mm is not None for frame in rendered)
    else:
        pictures = traced * (MOVE_S + pixels * render.samples * CAMERA_S + render.particles * PARTICLE_S)
    seconds = EPISODE_S[render.tier] + anchored * len(rendered) * pixels * LOOK_S + pictures
    seconds += (solved + FORCE_SOLVES * by_force) * SOLVE_S[scene.contact.quality]
    frames = scene.references + scene.frame_count
    pressed = sum(frame.state.gap_mm is not None and frame.state.gap_mm < 0 for frame in plan.frames)
    size = frames * (ROW_BYTES + pixels * (IMAGE_BYTES + MASK_BYTES * scene.output.contact_mask))
    size += pressed * pixels * DEPTH_BYTES * scene.output.depth_map
    size += pressed * taxel_bytes(scene) * TAXEL_SHARE
    size += pressed * lattice_nodes(scene) * NODE_BYTES * scene.output.displacements
    return seconds, size


def taxel_bytes(scene: SceneConfig) -> int:
    """Bytes of the fields of touch of a frame in memory; 0 where none are asked for."""
    taxels = scene.output.taxels
    if taxels is None:
        return 0
    images = 2 * taxels.skin + taxels.has_infill(scene.design)
    return taxels.rows * taxels.columns * 8 * (6 + images)


def lattice_nodes(scene: SceneConfig) -> float:
    """Nodes of the whole lattice, about."""
    design = scene.design
    spacing = node_spacing_mm(design)
    width, length = design.footprint_mm
    return (width / spacing + 3) * (length / spacing + 3) * (design.height_mm / spacing + 3)
