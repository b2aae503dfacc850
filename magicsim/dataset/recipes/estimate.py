"""What a dataset will cost, before any work starts: a rough model of the time, and the size of its pictures."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.camera.camera import Camera
from magicsim.dataset.recipes.draw import DrawnEpisode, sensor_of
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.geometry.grid import node_spacing_mm
from magicsim.scenes.scene import RECORDED_SAMPLES, RenderSettings, SceneConfig
from magicsim.simulation.plan import plan_scene

CAMERA_S, PARTICLE_S, SOLVE_S, MOVE_S, EPISODE_S, START_S = 2.2e-6, 7e-6, 1.0, 0.4, 1.5, 12.0
"""Core seconds of a camera sample, a light particle, a solved frame, meshes that move, an episode's meshes, a process's
start with its compilation; of the default design on one x86-64 core."""
LOOK_S, RECORD_S = 3e-6, 4e-6
"""Core seconds of a pixel that is seen by recorded paths, and of a camera sample that is recorded."""
TAXEL_SHARE = 0.3
"""Bytes of compressed fields of touch over those in memory: most taxels touch nothing."""
IMAGE_BYTES, MASK_BYTES, DEPTH_BYTES, NODE_BYTES, ROW_BYTES = 2.0, 0.02, 1.0, 6.0, 3000
"""A pixel of a frame, of a mask, of a depth map in contact, a lattice node in contact, the rest of a row."""
LOOKED_AT, COUNTED = 64, 256
"""Most episodes that are planned, and of which the frames are counted; the rest is taken to be like them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Time and size, roughly: within a factor of two or so."""

    frames: int
    core_seconds: float
    """Time on one core [s]."""
    bytes: int
    """Size of all shards."""

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

    Args:
        recipe: What they were drawn from.
        episodes: All of them.
        chosen: Numbers of those to be simulated, in order; all by default.
        processes: How many share the work; each renders every sensor's untouched state once.
    """
    numbers = np.arange(len(episodes)) if chosen is None else chosen
    planned, counted = _some(numbers, LOOKED_AT), _some(numbers, COUNTED)
    looked_at = [episodes[each] for each in planned]
    scale = len(numbers) / max(1, len(looked_at))
    costs = [episode_cost(each.scene) for each in looked_at]
    sensors = len({sensor_of(recipe, each) for each in counted})
    if len(counted) < len(numbers):
        sensors = min(len(numbers), int(sensor_of(recipe, int(numbers[-1] - numbers[0]))) + 1)
    anchors = min(processes * sensors, len(numbers))
    shared = _shared_s(recipe.render, recipe.rig.camera)
    seconds = scale * sum(cost[0] for cost in costs) + anchors * shared + processes * START_S
    frames = sum(recipe.references + episodes[each].scene.frame_count for each in counted)
    return Cost(
        frames=round(frames * len(numbers) / max(1, len(counted))),
        core_seconds=seconds,
        bytes=round(scale * sum(cost[1] for cost in costs)),
    )


def estimate_scene(scene: SceneConfig) -> Cost:
    """What one scene will cost in a process of its own."""
    seconds, size = episode_cost(scene)
    shared = _shared_s(scene.render, scene.rig.camera) + START_S
    return Cost(frames=scene.references + scene.frame_count, core_seconds=seconds + shared, bytes=round(size))


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


def episode_cost(scene: SceneConfig) -> tuple[float, float]:
    """Core seconds of an episode without the anchor, and the bytes of its rows."""
    render, camera, plan = scene.render, scene.rig.camera, plan_scene(scene)
    pixels = camera.rows * camera.columns
    rendered = [frame for frame in plan.frames if frame.same_as is None]
    solved, anchored = sum(frame.solve for frame in plan.frames), render.anchor_samples > 0
    traced = 1 + sum(frame.solve or not anchored for frame in rendered)
    seconds = EPISODE_S + solved * SOLVE_S + anchored * len(rendered) * pixels * LOOK_S
    seconds += traced * (MOVE_S + pixels * render.samples * CAMERA_S + render.particles * PARTICLE_S)
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
