"""Which estimator renders, and the scene that it asks for."""

from magicsim.errors import RenderError
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import VARIANT
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.variant import SCALAR_VARIANT
from magicsim.light.world.loaded_scene import World
from magicsim.light.world.scene_dict import WorldContent
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings

PATH_DEPTH = 256
"""Longest path of `volpath` [interactions], roulette off; four times as long changes the mean by 0.01 %."""
PATHS = {"type": "volpath", "max_depth": PATH_DEPTH, "rr_depth": PATH_DEPTH}
"""Mitsuba's path tracer, as an entry of its dictionaries."""


def choose_estimator(asked: str, elastomer: Elastomer, rig: Rig) -> str:
    """The estimator that will run: `fluence` needs LLVM or CUDA, and falls back to `path` on the scalar variant.

    Raises:
        RenderError: The body scatters and a lens plate is bonded to it, which `path` cannot tell apart.
    """
    estimator = "path" if VARIANT == SCALAR_VARIANT else asked
    if estimator == "path" and elastomer.design.materials.body.sigma_s_per_mm > 0 and rig.lens.thickness_mm > 0:
        msg = (
            f"lens.thickness_mm = {rig.lens.thickness_mm:g} is not allowed with estimator 'path' where the body "
            "scatters: must be 0; use estimator 'fluence'"
        )
        raise RenderError(msg)
    return estimator


def load_world(
    estimator: str, elastomer: Elastomer, rig: Rig, settings: RenderSettings, own_mesh: SurfaceMesh | None,
    beside: tuple[int, int], content: WorldContent,
) -> World:  # fmt: skip
    """The scene of a block, for paths or with its light.

    Args:
        estimator: As `choose_estimator` chose.
        elastomer: The block.
        rig: What surrounds it.
        settings: Collisions that are followed.
        own_mesh: The object that may come, in its own frame.
        beside: See `LitWorld`.
        content: What else is in the scene.
    """
    if estimator == "path":
        return World(elastomer, rig, content)
    return LitWorld(
        elastomer, rig, content, forward_collisions=settings.forward_collisions, own_mesh=own_mesh, beside=beside
    )
