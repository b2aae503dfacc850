"""What a dataset will cost, before any work starts: a rough model of the time, and the size of its pictures."""

from dataclasses import dataclass

from magicsim.dataset.draw import DrawnEpisode
from magicsim.dataset.recipe import Recipe
from magicsim.plan import plan_scene
from magicsim.scenes.scene import SceneConfig

CAMERA_S, PARTICLE_S, SOLVE_S, EPISODE_S, START_S = 2.2e-6, 1.5e-5, 2.0, 1.5, 12.0
"""Core seconds of a camera sample, a light particle, a solved frame, an episode's meshes, a process's start with its
compilation; of the default design on one x86-64 core."""
IMAGE_BYTES, MASK_BYTES, DEPTH_BYTES, NODE_BYTES, ROW_BYTES = 2.0, 0.02, 1.0, 6.0, 3000
"""A pixel of a frame, of a mask, of a depth map in contact, a lattice node in contact, the rest of a row."""
LOOKED_AT = 64
"""Episodes that are planned; the rest is taken to be like them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """Rough: within a factor of two or so."""

    frames: int
    core_seconds: float
    """Time on one core [s]."""
    bytes: int
    """Size of all shards."""

    def seconds(self, cores: int) -> float:
        """Time on some cores [s]."""
        return self.core_seconds / cores


def estimate(recipe: Recipe, episodes: list[DrawnEpisode], *, processes: int) -> Estimate:
    """What some of the episodes of a recipe will cost.

    Args:
        recipe: What they were drawn from.
        episodes: Those to be simulated.
        processes: How many share the work; each renders every sensor's untouched state once.
    """
    looked_at = episodes[:: max(1, len(episodes) // LOOKED_AT)]
    scale = len(episodes) / max(1, len(looked_at))
    costs = [_episode(each.scene) for each in looked_at]
    sensors = len({each.sensor for each in episodes})
    anchors = min(processes * sensors, len(episodes))
    seconds = scale * sum(cost[0] for cost in costs) + anchors * _anchor_s(recipe) + processes * START_S
    return Estimate(
        frames=sum(recipe.references + each.scene.frame_count for each in episodes),
        core_seconds=seconds,
        bytes=round(scale * sum(cost[1] for cost in costs)),
    )


def _anchor_s(recipe: Recipe) -> float:
    render, camera = recipe.render, recipe.rig.camera
    return camera.rows * camera.columns * render.anchor_samples * CAMERA_S + render.anchor_particles * PARTICLE_S


def _episode(scene: SceneConfig) -> tuple[float, float]:
    render, camera, plan = scene.render, scene.rig.camera, plan_scene(scene)
    pixels = camera.rows * camera.columns
    rendered = 1 + sum(frame.same_as is None for frame in plan.frames)
    solved = sum(frame.solve for frame in plan.frames)
    seconds = (
        EPISODE_S + solved * SOLVE_S + rendered * (pixels * render.samples * CAMERA_S + render.particles * PARTICLE_S)
    )
    frames = scene.references + scene.frame_count
    pressed = sum(frame.state.gap_mm is not None and frame.state.gap_mm < 0 for frame in plan.frames)
    size = frames * (ROW_BYTES + pixels * (IMAGE_BYTES + MASK_BYTES * scene.output.contact_mask))
    size += pressed * pixels * DEPTH_BYTES * scene.output.depth_map
    size += pressed * _nodes(scene) * NODE_BYTES * scene.output.displacements
    return seconds, size


def _nodes(scene: SceneConfig) -> float:
    design = scene.design
    spacing = design.lattice.spacing_mm or (design.cell_mm + design.wall_mm if design.has_grid else 1.0)
    width, length = design.footprint_mm
    return (width / spacing + 3) * (length / spacing + 3) * (design.height_mm / spacing + 3)
