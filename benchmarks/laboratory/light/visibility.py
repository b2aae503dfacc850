"""How far do the assumed optical constants matter? Contrast of the grid's lines at rest, and its change under a press.

Contrast is the standard deviation of the image's content at the pitch of the grid over its local mean: a sensor whose
grid cannot be seen feels nothing.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from laboratory.benchmark import logged, machine
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
SCATTERING_PER_MM = (0.1, 0.3, 1.0, 3.0)
INDICES = (1.43, 1.46, 1.475, 1.49)
"""Of the infill, the body's being 1.49; assumed ranges of both."""
WIDTH_PITCHES = 0.5
"""Standard deviation of the local mean in pitches."""
CONTACT_SHARE = 0.5
"""Part of the contact's radius that the change is averaged over."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VisibilityRow:
    """One pair of constants."""

    sigma_s_per_mm: float
    ior: float
    contrast: float
    """At rest, mean over the middle of the image."""
    contrast_pressed: float
    """In the middle of a contact, 1 mm deep."""
    brightness: float
    """Mean grey level in the middle of the contact over that at rest."""


def run_visibility(*, quick: bool = False) -> dict[str, Any]:
    """All pairs.

    Args:
        quick: The extremes alone, on a small image.
    """
    scattering = SCATTERING_PER_MM[::3] if quick else SCATTERING_PER_MM
    indices = INDICES[::3] if quick else INDICES
    rows = logged(measure_visibility(sigma, ior, quick=quick) for sigma in scattering for ior in indices)
    return {"kind": "visibility", "quick": quick, "results": [asdict(row) for row in rows], "machine": machine()}


def measure_visibility(sigma_s_per_mm: float, ior: float, *, quick: bool = False) -> VisibilityRow:
    """One row.

    Args:
        sigma_s_per_mm: Reduced scattering coefficient of the infill [1/mm].
        ior: Its refractive index.
        quick: A small image.
    """
    small = ["rig.camera.columns=96", "rig.camera.rows=128"] if quick else []
    scene = load_scene(
        "pressed",
        [f"design.materials.infill.sigma_s_per_mm={sigma_s_per_mm}", f"design.materials.infill.ior={ior}",
         "render.samples=24", "render.particles=400000", "render.anchor_samples=0", *small],
    )  # fmt: skip
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    rest = sensor.renderer.plain_radiance(sensor.view(UNTOUCHED, sensor.rest)).astype(np.float64)
    pressed = sensor.renderer.plain_radiance(sensor.view(state, sensor.deform(state, sensor.rest))).astype(np.float64)
    gain = 1 / rest.mean((0, 1))
    rest, pressed = (rest * gain).mean(-1), (pressed * gain).mean(-1)
    pixel_mm = scene.rig.camera.field_mm / scene.rig.camera.columns
    middle = _disc(rest.shape, CONTACT_SHARE * _contact_radius_mm(sensor, scene) / pixel_mm)
    width = WIDTH_PITCHES * (scene.design.cell_mm + scene.design.wall_mm) / pixel_mm
    return VisibilityRow(
        sigma_s_per_mm=sigma_s_per_mm,
        ior=ior,
        contrast=grid_contrast(rest, middle, width),
        contrast_pressed=grid_contrast(pressed, middle, width),
        brightness=float(pressed[middle].mean() / rest[middle].mean()),
    )


def grid_contrast(image: Array, where: npt.NDArray[np.bool_], width_px: float) -> float:
    """Root mean square of an image about its local mean, over that mean.

    Args:
        image: Brightness, shape (rows, columns).
        where: Pixels that count, same shape.
        width_px: Standard deviation of the local mean [px].
    """
    local = gaussian_filter(image, width_px)
    return float(np.sqrt(((image - local)[where] ** 2).mean()) / local[where].mean())


def _contact_radius_mm(sensor: Sensor, scene: SceneConfig) -> float:
    area = sensor.deform(timeline(scene)[0], sensor.rest).contact_area_mm2
    return float(np.sqrt(area / np.pi))


def _disc(shape: tuple[int, ...], radius_px: float) -> npt.NDArray[np.bool_]:
    row, column = np.indices(shape[:2])
    return np.asarray(np.hypot(row - (shape[0] - 1) / 2, column - (shape[1] - 1) / 2) < radius_px)
