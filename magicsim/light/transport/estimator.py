"""Which estimator renders, and its entry of a scene's dictionary."""

from typing import Any

from magicsim.errors import RenderError
from magicsim.geometry.elastomer import Elastomer
from magicsim.light.backend import VARIANT
from magicsim.light.variant import SCALAR_VARIANT
from magicsim.light.world.finish import Finish
from magicsim.light.world.scene_dict import lights_inside, lights_off
from magicsim.scenes.rig import INSET_MM, Rig
from magicsim.scenes.scene import RenderSettings

PATH_DEPTH = 256
"""Longest path of `volpath` [interactions], roulette off; four times as long changes the mean by 0.01 %."""


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


def integrator_entry(
    estimator: str, elastomer: Elastomer, rig: Rig, settings: RenderSettings, finish: Finish
) -> dict[str, Any]:
    """The integrator's entry of a scene dictionary.

    Args:
        estimator: As `choose_estimator` chose.
        elastomer: The block.
        rig: What surrounds it.
        settings: Particles, and collisions that are followed.
        finish: Surface of the object.
    """
    if estimator == "path":
        return {"type": "volpath", "max_depth": PATH_DEPTH, "rr_depth": PATH_DEPTH}
    import magicsim.light.transport.integrator  # noqa: F401 -- registers the estimator
    from magicsim.light.transport.integrator_settings import integrator_settings

    return {
        "type": "fluence",
        "particles": settings.particles,
        "forward_collisions": settings.forward_collisions,
        **integrator_settings(elastomer, finish, inside=lights_inside(rig), off=lights_off(rig), inset_mm=INSET_MM),
    }
