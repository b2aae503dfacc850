"""Does light stay right at extremes? White furnace and energy balance of one sensor in one state.

Without absorption and with radiance 1 all around, the fluence in a medium of index n is 4 pi n^2 everywhere, and a
camera sees 1 less the part that it would see mirrored in the lens face, which the dark housing keeps away.
"""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from magicsim.geometry.design import ElastomerDesign
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.world.finish import Finish
from magicsim.light.world.names import ENVIRONMENT
from magicsim.light.world.scene_dict import WorldContent
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor

SMALL = (
    "rig.camera.columns=48", "rig.camera.rows=64", "render.samples=16", "render.particles=60000",
    "render.anchor_samples=0",
)  # fmt: skip
PARTICLES_PER_CELL = 250
"""Of the furnace: a cell's fluence is then known to some per cent."""
LEAST_PARTICLES, MOST_PARTICLES = 800_000, 8_000_000
BALANCE_PARTICLES = 50_000
"""Of each light."""
CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "default, rest": ("rest", ()),
    "default, 1 mm press": ("pressed", ()),
    "50 % press": ("pressed", ("keyframes=[{frame=0,gap_mm=-3.3}]", "object.radius_mm=8")),
    "object in full contact": (
        "pressed",
        ("object={kind='box',size_mm=[30,40,4],edge_radius_mm=0.5}", "keyframes=[{frame=0,gap_mm=-0.5}]"),
    ),
    "skin 0.1 mm, 0.3 mm press": ("pressed", ("design.skin_mm=0.1", "keyframes=[{frame=0,gap_mm=-0.3}]")),
    "cell 3 mm": ("pressed", ("design.cell_mm=3", "design.core_mm=6.4")),
    "cell 0.3 mm, 57k cells": ("rest", ("design.cell_mm=0.3", "design.wall_mm=0.1", "design.lattice.spacing_mm=0.8")),
    "wall 0.05 mm": ("pressed", ("design.wall_mm=0.05", "design.cell_mm=0.95")),
    "equal indices": ("pressed", ("design.materials.infill.ior=1.49",)),
    "infill of index 1.0": ("pressed", ("design.materials.infill.ior=1.0",)),
    "infill of index 2.0": ("pressed", ("design.materials.infill.ior=2.0",)),
    "no scattering": ("pressed", ("design.materials.infill.sigma_s_per_mm=0",)),
    "scattering 10 per mm": ("pressed", ("design.materials.infill.sigma_s_per_mm=10",)),
    "forward scattering 10 per mm, g 0.9": (
        "pressed", ("design.materials.infill.sigma_s_per_mm=10", "design.materials.infill.anisotropy=0.9"),
    ),
    "scattering body 10 per mm": ("pressed", ("design.materials.body.sigma_s_per_mm=10",)),
    "strong absorption": (
        "pressed",
        ("design.materials.infill.absorption_per_mm=10", "design.materials.body.absorption_per_mm=1"),
    ),
}  # fmt: skip
"""Name of a scene and what is changed of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticsRow:
    """What one case shows; relative errors, all without a unit."""

    case: str
    is_finite: bool
    """Whether images with the scene's own materials hold no NaN and nothing negative."""
    fluence_error: float | None
    """Mean over the cells of a furnace, less one; None where nothing scatters, as their fluence is then left out."""
    least_cell: float | None
    most_cell: float | None
    """Cells that are farthest off in the same direction in two independent runs, less one."""
    camera_error: float
    """Mean of the furnace's image over what it must be, less one."""
    balance_error: float
    """Light that is absorbed or escapes over what the lights emit, less one."""
    seconds: float


def check_optics(case: str, *overrides: str, share: float = 1.0) -> OpticsRow:
    """Checks one of `CASES`.

    Args:
        case: Its name.
        overrides: Further settings, `dotted.key=value`.
        share: Of the particles that are enough for every case.

    Raises:
        MagicsimError: The state cannot be solved or rendered, with the figures that say why.
    """
    start = time.perf_counter()
    state, changes = CASES[case]
    scene = load_scene(state, [*SMALL, *changes, *overrides])
    sensor, frame = Sensor.for_scene(scene), timeline(scene)[0]
    view = sensor.view(frame, sensor.deform(frame, sensor.rest) if frame.can_touch else sensor.rest)
    image = sensor.renderer.plain_radiance(view)
    world = sensor.renderer.light(view)
    balance = _balance(world, int(share * BALANCE_PARTICLES), sensor.seed)
    first, second = (_furnace(sensor, scene, view, share, seed) for seed in (1, 2))
    filled = world.media.infill.sigma_s > 0
    cells = (first[0] + second[0]) / 2
    return OpticsRow(
        case=case,
        is_finite=bool(np.isfinite(image).all() and (image >= 0).all()),
        fluence_error=float(cells.mean()) - 1 if filled else None,
        least_cell=float(np.maximum(first[0], second[0]).min()) - 1 if filled else None,
        most_cell=float(np.minimum(first[0], second[0]).max()) - 1 if filled else None,
        camera_error=(first[1] + second[1]) / 2 - 1,
        balance_error=balance,
        seconds=time.perf_counter() - start,
    )


def _furnace(
    sensor: Sensor,
    scene: SceneConfig,
    view: Any,  # noqa: ANN401
    share: float,
    seed: int,
) -> tuple[np.ndarray, float]:
    """Fluence of each cell over what it must be, and the image's mean over what that must be."""
    clear = sensor.elastomer.design.model_dump()
    for material in clear["materials"].values():
        material["absorption_per_mm"] = 0.0
    design = ElastomerDesign.model_validate(clear)
    elastomer = replace(sensor.elastomer, design=design)
    content = WorldContent(object_mesh=None, object_finish=Finish(), flashlight=False, furnace=True)
    dark = scene.rig.model_copy(update={"strips": ()})
    world = LitWorld(elastomer, dark, content, forward_collisions=scene.render.forward_collisions)
    if view.body is not None:
        world.update(body=view.body, infill=view.infill)
    media, cells = design.materials, world.inventory.shapes().cells
    particles = int(share * np.clip(PARTICLES_PER_CELL * cells, LEAST_PARTICLES, MOST_PARTICLES))
    field = world.light_fields({ENVIRONMENT: particles}, seed=seed)[ENVIRONMENT]
    infill = media.infill.ior if media.infill is not None else media.body.ior
    due = 4 * np.pi * infill**2
    even = replace(field, fluence=np.full_like(field.fluence, due))
    if world.voxels is not None:
        held = world.held_mm3()
        even = replace(even, body=np.broadcast_to(4 * np.pi * media.body.ior**2 * held, field.body.shape))
    image = np.array(world.gather(even, samples=scene.render.samples, seed=seed))
    mirrored = ((media.body.ior - 1) / (media.body.ior + 1)) ** 2
    return (field.fluence / due).mean(1), float(image.mean() / (1 - mirrored))


def _balance(world: LitWorld, particles: int, seed: int) -> float:
    spent = emitted = 0.0
    for name in world.lights:
        account = world.balance(name, particles=particles, seed=seed)
        spent += account["absorbed"] + account["escaped"]
        emitted += account["emitted"]
    return spent / emitted - 1
