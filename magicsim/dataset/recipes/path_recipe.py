"""What happens in an episode: paths of a recipe, and the keyframes that a drawn one becomes."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field

from magicsim.config.models import Config
from magicsim.dataset.recipes.object_recipe import Draw, Weight
from magicsim.sampling.distribution import Number

Frames = Annotated[int, Field(ge=0, le=1000)]
SomeFrames = Annotated[int, Field(ge=1, le=1000)]
TOUCHING_MM = 0.1
"""Gap at which an approach ends and a press begins [mm]."""
Table = dict[str, Any]


class PathBase(Config):
    """What every path has."""

    weight: Weight = 1.0
    """How often this entry is chosen, relative to the others."""

    def numbers(self) -> dict[str, Number]:
        """All numbers by name."""
        names = [name for name in type(self).model_fields if name not in {"kind", "weight"}]
        return {name: getattr(self, name) for name in names if not name.endswith("frames")}


class TouchPath(PathBase):
    """Approach, press, shear, twist, hold, release; phases of no frames are left out."""

    kind: Literal["touch"]
    x_mm: Number = 0.0
    """Where the object's origin comes down, along x [mm]."""
    y_mm: Number = 0.0
    gap_mm: Number = 10.0
    """Distance at which the approach begins [mm]."""
    depth_mm: Number
    """Press from first contact [mm]."""
    shear_mm: Number = 0.0
    """Slide along the face once pressed [mm]."""
    shear_direction_deg: Number = 0.0
    """Direction of the slide, from x towards y [degrees]."""
    twist_deg: Number = 0.0
    """Turn about z once pressed [degrees]."""
    friction: Number = 0.0
    """Coulomb's coefficient."""
    approach_frames: SomeFrames = 5
    press_frames: SomeFrames = 4
    shear_frames: Frames = 3
    twist_frames: Frames = 3
    hold_frames: Frames = 1
    release_frames: Frames = 2

    def keyframes(self, drawn: dict[str, float]) -> list[Table]:
        """Keyframes of the drawn path."""
        turn, slide = math.radians(drawn["shear_direction_deg"]), drawn["shear_mm"]
        place = {"x_mm": drawn["x_mm"], "y_mm": drawn["y_mm"]}
        slid, turned = place, {}
        if self.shear_frames:
            slid = {"x_mm": place["x_mm"] + slide * math.cos(turn), "y_mm": place["y_mm"] + slide * math.sin(turn)}
        if self.twist_frames:
            turned = {"twist_deg": drawn["twist_deg"]}
        far, pressed = {"gap_mm": drawn["gap_mm"]}, {"gap_mm": -drawn["depth_mm"]}
        return _timed(
            [
                (0, place | far),
                (self.approach_frames, place | {"gap_mm": min(TOUCHING_MM, drawn["gap_mm"])}),
                (self.press_frames, place | pressed),
                (self.shear_frames, slid | pressed),
                (self.twist_frames, slid | turned | pressed),
                (self.hold_frames, slid | turned | pressed),
                (self.release_frames, slid | turned | far),
            ]
        )


class HoverPath(PathBase):
    """Approach without touching, and retreat."""

    kind: Literal["hover"]
    x_mm: Number = 0.0
    y_mm: Number = 0.0
    gap_mm: Number = 10.0
    """Distance at which the approach begins [mm]."""
    nearest_mm: Number
    """Smallest distance [mm]."""
    approach_frames: SomeFrames = 6
    retreat_frames: Frames = 4

    def keyframes(self, drawn: dict[str, float]) -> list[Table]:
        """Keyframes of the drawn path."""
        place = {"x_mm": drawn["x_mm"], "y_mm": drawn["y_mm"]}
        far, near = place | {"gap_mm": drawn["gap_mm"]}, place | {"gap_mm": drawn["nearest_mm"]}
        return _timed([(0, far), (self.approach_frames, near), (self.retreat_frames, far)])


class FlashlightPath(PathBase):
    """Outside light moves across, without an object."""

    kind: Literal["flashlight"]
    light_x_mm: Number = 0.0
    """Where the light begins, along x [mm]."""
    travel_mm: Number = 0.0
    """How far it moves along x [mm]."""
    strength: Number = 1.0
    """Factor on the rig's flashlight."""
    lit_frames: SomeFrames = 4

    def keyframes(self, drawn: dict[str, float]) -> list[Table]:
        """Keyframes of the drawn path."""
        start, end = drawn["light_x_mm"], drawn["light_x_mm"] + drawn["travel_mm"]
        lit: Table = {"flashlight": True}
        return _timed([(0, lit | {"light_x_mm": start}), (self.lit_frames - 1, lit | {"light_x_mm": end})])


class ClearPath(PathBase):
    """Nothing near."""

    kind: Literal["clear"]
    clear_frames: SomeFrames = 4

    def keyframes(self, drawn: dict[str, float]) -> list[Table]:
        """Keyframes of the path."""
        return _timed([(0, {}), (self.clear_frames - 1, {})])


AnyPath = TouchPath | HoverPath | FlashlightPath | ClearPath
PathRecipe = Annotated[AnyPath, Field(discriminator="kind")]


def draw_path(path: AnyPath, draw: Draw) -> dict[str, float]:
    """Values of all numbers of a path."""
    return {name: draw(name, number) for name, number in path.numbers().items()}


def _timed(steps: list[tuple[int, Table]]) -> list[Table]:
    """Keyframes from durations [frames] and states; all but the first of no duration are left out."""
    frame, result = 0, [{"frame": 0, **steps[0][1]}]
    for frames, state in steps[1:]:
        if frames:
            frame += frames
            result.append({"frame": frame, **state})
    return result
