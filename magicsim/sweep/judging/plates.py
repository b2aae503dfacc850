"""Plates with dots, lines or nothing on them, pressed in the middle of the face and seen from below.

Plate, lattice and the part that is looked at grow with the spacing, so that every spacing is judged alike. Dots and
lines are their own mirror images about the axis: a quarter of the block is solved.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.exposure import expose
from magicsim.camera.film import pixel_landing_mm
from magicsim.detectors.frame import Frame
from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import BoxObject, DotsObject, LinesObject, ObjectConfig
from magicsim.light.records.untouched_states import UntouchedStates
from magicsim.scenes.rig import Rig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor, sensor_exposure
from magicsim.sweep.judging.central_press import followed_finely, moved, press_centrally
from magicsim.sweep.judging.quality import Quality
from magicsim.sweep.sensors import SweptSensor, camera_of, render_of

Pattern = Literal["dots", "lines"]
PLATE_PERIODS = 5
"""Side of the plates in units of the spacing."""
LOOKED_AT_PERIODS = 4
"""Side of the square of the face on which contrast is measured, in the same units: less than the plate, whose edges are
no pattern, and enough for the peak of the pattern's frequency to be narrow."""
CELLS_A_PERIOD = 3
"""Lattice cells along one spacing below a pattern; half as many below a plain plate, which bends the face less."""
MARGIN_PX = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateFrames:
    """Frames of one pressed plate on its place of the face."""

    contrast: Array
    """Change of grey level in units of the untouched sensor's mean, shape (draws, pixels, 3)."""
    places_mm: Array
    """Where the pixels look on the face, shape (pixels, 2) [mm]."""
    picture: Frame
    """The first frame, whole."""


def plate(pattern: Pattern | None, spacing_mm: float, like: ObjectConfig | None = None) -> ObjectConfig:
    """A plate with dots or lines half as wide as their spacing, or without, with the colour of another object."""
    size = PLATE_PERIODS * spacing_mm
    look = like.model_dump(include={"color", "specular", "roughness"}) if like is not None else {}
    if pattern == "dots":
        return DotsObject(kind="dots", radius_mm=spacing_mm / 4, spacing_mm=spacing_mm, size_mm=size, **look)
    if pattern == "lines":
        return LinesObject(kind="lines", width_mm=spacing_mm / 2, spacing_mm=spacing_mm, size_mm=size, **look)
    return BoxObject(kind="box", size_mm=(size, size, 2.0), **look)


def press_plate(
    sensor: SweptSensor,
    pattern: Pattern | None,
    spacing_mm: float,
    quality: Quality,
    *,
    like: ObjectConfig,
    seed: int,
    untouched: UntouchedStates,
) -> PlateFrames:
    """Presses a plate on the axis and looks at its place.

    Args:
        sensor: What is pressed.
        pattern: What is on the plate.
        spacing_mm: Of the pattern, or of the one that a plain plate is compared with [mm].
        quality: Depth and images.
        like: What the plate has its colour from.
        seed: Of rendering and noise.
        untouched: Untouched states that other scenes share.

    Raises:
        MagicsimError: The plate does not fit on the face, or the design, the deformation or an image is not valid.
    """
    if PLATE_PERIODS * spacing_mm > min(sensor.design.footprint_mm):
        msg = f"a plate of {PLATE_PERIODS} x {spacing_mm:g} mm is larger than the face"
        raise ConfigError(msg)
    thing = plate(pattern, spacing_mm, like)
    rig, design = plate_rig(sensor, spacing_mm, quality), followed_finely(sensor.design)
    cells = CELLS_A_PERIOD if pattern is not None else CELLS_A_PERIOD / 2
    pressed = press_centrally(
        sensor.design, thing, quality.texture_depth_mm, cells_across=1, spacing_mm=spacing_mm / cells
    )
    state = replace(UNTOUCHED, gap_mm=-quality.texture_depth_mm)
    simulated = Sensor(
        design, rig, thing, render=render_of(sensor, quality), states=[state], seed=seed, untouched=untouched
    )
    rest = simulated.radiance(UNTOUCHED, simulated.rest)
    image = simulated.radiance(state, moved(simulated, state, pressed))
    camera, exposure = rig.camera, sensor_exposure(simulated, rest)

    def frames(radiance: FloatImage, first: int) -> Array:
        return np.stack(
            [expose(radiance, exposure, camera, seed=seed, frame=first + draw) for draw in range(quality.draws)]
        ).astype(float)

    shown, reference = frames(image, 0), frames(rest, quality.draws).mean(0)
    landing = pixel_landing_mm(design, rig.lens, rig.camera)
    inside = np.abs(landing).max(2) <= LOOKED_AT_PERIODS * spacing_mm / 2
    contrast = ((shown - reference) / reference[inside].mean(0))[:, inside]
    return PlateFrames(contrast=contrast, places_mm=landing[inside], picture=shown[0].astype(np.uint8))


def plate_rig(sensor: SweptSensor, spacing_mm: float, quality: Quality) -> Rig:
    """The rig of a sensor, its camera reading out what lies around a plate of `PLATE_PERIODS` spacings."""
    camera = camera_of(sensor, quality, scale=quality.texture_scale)
    whole = sensor.rig.model_copy(update={"camera": camera})
    near = np.abs(pixel_landing_mm(sensor.design, whole.lens, whole.camera)).max(2) <= PLATE_PERIODS * spacing_mm / 2
    rows, columns = np.flatnonzero(near.any(1)), np.flatnonzero(near.any(0))
    top, left = max(0, rows[0] - MARGIN_PX), max(0, columns[0] - MARGIN_PX)
    bottom, right = min(camera.rows, rows[-1] + 1 + MARGIN_PX), min(camera.columns, columns[-1] + 1 + MARGIN_PX)
    region = (int(left), int(top), int(right - left), int(bottom - top))
    looking = camera.pixelwise().model_copy(update={"region_px": region})
    return sensor.rig.model_copy(update={"camera": looking})
