"""How far an object can be seen: beyond that it is left out, and no pixel changes by more than a stated bound.

In a dark room nothing is brighter than the lights, so what is at distance d from the middle of a sphere of radius r
around block and lights sees no more than the brightest light's radiance, from within the sphere's solid angle
2 pi (1 - sqrt(1 - (r / d)^2)). A matte object sends reflectance / pi of that back at most, and a block that only bends,
scatters and absorbs makes nothing of it brighter.
"""

import math

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.camera import Camera
from magicsim.camera.exposure import meter
from magicsim.geometry.design import ElastomerDesign
from magicsim.light.world.finish import Finish
from magicsim.light.world.scene_dict import AIR_GAP_MM
from magicsim.scenes.refusals import lamps_mm
from magicsim.scenes.rig import Rig

FAINT_LEVELS = 0.5
"""What cannot change any pixel by more is left out [grey levels]: rounding to 8 bit does as much."""


def is_out_of_reach(gap_mm: float, finish: Finish, design: ElastomerDesign, rig: Rig, untouched: FloatImage) -> bool:
    """Whether an object is too far to be seen.

    Never where the room is lit, since an object hides what is behind it at any distance, nor where it mirrors: a
    mirror is as bright as what it shows; nor where exposure is live, since gains then are not known beforehand.

    The flashlight counts as on; `untouched` is the linear radiance of the whole sensor at rest, on which exposure is
    locked.
    """
    if (
        rig.camera.live is not None
        or max(rig.room_light) > 0
        or finish.specular > 0
        or finish.is_ghost
        or gap_mm <= rig.flashlight.distance_mm
    ):
        return False
    sent_back = brightest_return(gap_mm, finish, design, rig)
    return (
        grey_levels(sent_back, meter(untouched, rig.camera, rig.lit(is_opaque=design.is_opaque)), rig.camera)
        <= FAINT_LEVELS
    )


def brightest_return(gap_mm: float, finish: Finish, design: ElastomerDesign, rig: Rig) -> Array:
    """Bound of the radiance of each channel that a matte object sends back, shape (3,); arguments as above."""
    height = design.height_mm + rig.lens.thickness_mm
    radius = float(np.linalg.norm([*design.footprint_mm, height])) / 2 + AIR_GAP_MM
    for aside, above, size in lamps_mm(design, rig).values():
        radius = max(radius, math.hypot(aside, above - height / 2) + size)
    distance = gap_mm + height / 2
    if distance <= radius:
        return np.full(3, np.inf)
    solid_angle = 2 * np.pi * (1 - np.sqrt(1 - (radius / distance) ** 2))
    brightest = np.max([rig.flashlight.radiance, *rig.lamps], axis=0)
    reflectance = np.ones(3) if finish.vertex_colors else np.array(finish.color)
    return np.asarray(reflectance / np.pi * solid_angle * brightest)


def grey_levels(radiance: Array, gain: Array, camera: Camera) -> float:
    """The most that a radiance of each channel can add to a pixel, where the tone curve is steepest [grey levels]."""
    signal = np.abs(np.array(camera.color_matrix)) @ radiance * gain
    # signal^(1 / gamma) is steepest at black, or at white, where its slope is 1 / gamma.
    rise = signal ** (1 / camera.gamma) if camera.gamma > 1 else signal / camera.gamma
    return float(255 * rise.max())
