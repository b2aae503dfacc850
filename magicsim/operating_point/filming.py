"""The few states in which the published figures are read, rendered for one choice of the optical constants."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.fit.constants import with_values
from magicsim.fit.equilibria import Equilibria
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor

FloatImage = npt.NDArray[np.float32]
GAPS_MM = (40.0, 20.0, 12.0, 6.0, 3.0, 1.0)
"""Where the approaching object is looked at."""
TOUCH_MM = 0.3
"""Depth of a light contact."""
OBJECT = "object={kind='sphere',radius_mm=36.0,color=[0.58,0.33,0.23]}"
"""A large object: a ball of an orange's size in the colour of a hand."""
QUALITY = ("render.samples=2", "render.particles=20000", "render.anchor_samples=8", "render.anchor_particles=150000")

_equilibria = Equilibria()


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmedStates:
    """Linear radiance of one sensor, each of shape (rows, columns, 3)."""

    rest: FloatImage
    near: FloatImage
    """At `GAPS_MM`, shape (gaps, rows, columns, 3)."""
    touch: FloatImage
    light: FloatImage
    """What a flashlight of the rig's strength adds to the untouched sensor; never negative."""


def search_scene(columns: int, rows: int, quality: tuple[str, ...] = QUALITY) -> SceneConfig:
    """The default sensor with a large object in front, at some size of the image."""
    size = (f"rig.camera.columns={columns}", f"rig.camera.rows={rows}")
    return load_scene("near", [OBJECT, *size, *quality])


def film_states(scene: SceneConfig, values: Mapping[str, object]) -> FilmedStates:
    """All states of the sensor of a scene with some constants changed.

    Args:
        scene: From `search_scene`.
        values: By dotted field, as in `magicsim.fit.constants.with_values`.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
    """
    sensor = Sensor(with_values(scene, values))
    state = replace(UNTOUCHED, gap_mm=0.0)
    rest = sensor.radiance(UNTOUCHED, sensor.rest)
    near = [sensor.radiance(replace(state, gap_mm=gap), sensor.rest) for gap in GAPS_MM]
    contact = replace(state, gap_mm=-TOUCH_MM)
    touch = sensor.radiance(contact, _equilibria.of(sensor, contact))
    light = sensor.radiance(replace(UNTOUCHED, flashlight=True), sensor.rest)
    return FilmedStates(
        rest=rest, near=np.stack(near), touch=touch, light=np.maximum(light - rest, 0).astype(np.float32)
    )
