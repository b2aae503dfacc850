"""By which way light and image of a frame were made, in the words of the tables of frames.

They tell where numbers come from, and nothing about the world: a network that is given them learns the renderer.
"""

from dataclasses import dataclass
from typing import Literal

LightWay = Literal["", "untouched", "outside", "before contact", "traced", "alone"]
"""`untouched`: that of the untouched sensor. `outside`: that, and what object and lamps outside change of it.
`before contact`: kept of the last state before contact (`render.light_change`). `traced`: particles of the frame in the
deformed block, anchored. `alone`: without the untouched sensor (`render.anchor_samples = 0`, or `volpath`)."""
ImageWay = Literal["", "untouched", "recorded", "traced", "alone"]
"""`untouched`: the careful image of the untouched sensor. `recorded`: all of its camera paths, in other light.
`traced`: paths of some pixels traced anew, where something moved. `alone`: as for light."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """How one frame was made; empty where nobody said."""

    light: LightWay = ""
    image: ImageWay = ""


UNKNOWN = Way()
ALONE = Way(light="alone", image="alone")
UNTOUCHED = Way(light="untouched", image="untouched")
