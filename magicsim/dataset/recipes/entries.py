"""Entries of a recipe: the objects that it presses, any kind of `magicsim.geometry.objects.kinds`, and the paths.

A path that was drawn becomes keyframes.
"""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from magicsim.config.models import Config, validate
from magicsim.config.named_files import MESH_SUFFIXES
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.objects.kinds import OBJECT_KINDS
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.sampling.distribution import Distribution, Number, choose

Draw = Callable[[str, Number], float]
"""Value of a named number."""
Kind = Literal[
    "sphere", "cylinder", "punch", "box", "domed_cylinder", "cone", "dots", "lines", "spanner", "screwdriver",
    "scissors", "banana", "plug", "mesh",
]  # fmt: skip
Weight = Annotated[float, Field(ge=1e-6, le=1e6)]
OWN_KEYS = frozenset({"kind", "weight", "folder"})
NOT_DRAWN = frozenset({"path", "axis", "flutes", "file_colors"})


class ObjectRecipe(Config):
    """One kind of object; its keys are those of `magicsim info schema object`, and numbers may be distributions."""

    kind: Kind
    weight: Weight = 1.0
    """How often this entry is chosen, relative to the others."""
    color: tuple[Number, Number, Number] | None = None
    """Diffuse reflectance in linear RGB."""
    specular: Number | None = None
    """Gloss: share of the light that the surface mirrors."""
    roughness: Number | None = None
    """Root mean square slope of the facets that mirror."""
    roll_deg: Number | None = None
    pitch_deg: Number | None = None
    yaw_deg: Number | None = None
    radius_mm: Number | None = None
    length_mm: Number | None = None
    axis: Literal["x", "y", "z"] | None = None
    edge_radius_mm: Number | None = None
    size_mm: Number | tuple[Number, Number, Number] | None = None
    half_angle_deg: Number | None = None
    tip_radius_mm: Number | None = None
    flat_radius_mm: Number | None = None
    spacing_mm: Number | None = None
    width_mm: Number | None = None
    height_mm: Number | None = None
    thickness_mm: Number | None = None
    jaw_mm: Number | None = None
    head_radius_mm: Number | None = None
    handle_width_mm: Number | None = None
    flutes: Annotated[int, Field(ge=3, le=12)] | None = None
    tube_radius_mm: Number | None = None
    loop_width_mm: Number | None = None
    loop_length_mm: Number | None = None
    gap_mm: Number | None = None
    bend_radius_mm: Number | None = None
    pin_radius_mm: Number | None = None
    pin_length_mm: Number | None = None
    path: str | None = None
    """File of a `mesh`; a relative path starts beside the recipe, or in the current folder."""
    folder: str | None = None
    """Folder of a `mesh`, instead of `path`: every mesh file in it is as likely as any other."""
    scale: Number | None = None
    file_colors: bool | None = None
    """Whether the file of a `mesh` gives the colour."""
    feature_mm: Number | None = None

    def _problems(self) -> Iterator[str | None]:
        fields = OBJECT_KINDS[self.kind].model_fields
        for key in self.model_fields_set - OWN_KEYS:
            if key not in fields:
                yield unknown_choice(f"key of object kind '{self.kind}'", key, set(fields) - {"kind"})
        if self.kind != "mesh":
            if self.folder is not None:
                yield f"folder is not a key of object kind '{self.kind}', only of 'mesh'"
        elif (self.path is None) == (self.folder is None):
            yield "object kind 'mesh' needs either path or folder"
        missing = [
            key
            for key, field in fields.items()
            if field.is_required() and getattr(self, key, None) is None and not (key == "path" and self.folder)
        ]
        if missing:
            yield f"{missing[0]} is missing: object kind '{self.kind}' needs it"

    def files(self) -> tuple[str, ...]:
        """Mesh files that may be drawn, sorted; `ConfigError` where the folder holds none."""
        if self.folder is None:
            return (self.path,) if self.path is not None else ()
        meshes = sorted(path for path in Path(self.folder).glob("*") if path.suffix.lower() in MESH_SUFFIXES)
        if not meshes:
            raise ConfigError(f"folder = '{self.folder}' holds no mesh file ({', '.join(sorted(MESH_SUFFIXES))})")
        return tuple(path.as_posix() for path in meshes)

    def numbers(self) -> dict[str, Number]:
        """All numbers by name, tuples taken apart."""
        result: dict[str, Number] = {}
        for key in sorted(self.model_fields_set - OWN_KEYS - NOT_DRAWN):
            value = getattr(self, key)
            parts = value if isinstance(value, tuple) else (value,)
            for place, part in enumerate(parts):
                result[f"{key}.{place}" if len(parts) > 1 else key] = part
        return result

    def draw(self, draw: Draw, share: float) -> ObjectBase:
        """One object: `draw` gives the value of each number, `share` in [0, 1) chooses the mesh file."""
        drawn = {name: draw(name, number) for name, number in self.numbers().items()}
        values: dict[str, Any] = {"kind": self.kind}
        for key in self.model_fields_set - OWN_KEYS:
            value = getattr(self, key)
            if isinstance(value, tuple):
                values[key] = tuple(drawn[f"{key}.{place}"] for place in range(len(value)))
            else:
                values[key] = drawn.get(key, value)
        if self.kind == "mesh":
            files = self.files()
            values["path"] = files[choose(share, (1.0,) * len(files))]
        return validate(OBJECT_KINDS[self.kind], values, source=f"object '{self.kind}'")


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
        numbers = {name: getattr(self, name) for name in names if not name.endswith("frames")}
        return {name: number for name, number in numbers.items() if number is not None}


class TouchPath(PathBase):
    """Approach, press, shear, twist, hold, release; phases of no frames are left out."""

    kind: Literal["touch"]
    x_mm: Number = 0.0
    """Where the object's origin comes down, along x [mm]."""
    y_mm: Number = 0.0
    gap_mm: Number = 10.0
    """Distance at which the approach begins [mm]."""
    depth_mm: Number | None = None
    """Press from first contact [mm]; beside a force its end in any case. A force alone ends at the depth that the
    design's `limits` name."""
    force_n: Number | None = None
    """Normal force at which the press ends [N], whose depth is found on the way; within 5 %."""
    shear_mm: Number = 0.0
    """Slide along the face once pressed [mm]."""
    shear_direction_deg: Number = 0.0
    """Direction of the slide, from x towards y [degrees]."""
    twist_deg: Number = 0.0
    """Turn about z once pressed [degrees]."""
    friction: Number = 0.0
    """Coulomb's coefficient."""
    approach_frames: Frames = 5
    """Frames before contact; none begins with the press."""
    press_frames: SomeFrames = 4
    shear_frames: Frames = 3
    twist_frames: Frames = 3
    hold_frames: Frames = 1
    release_frames: Frames = 2

    def _problems(self) -> Iterator[str | None]:
        if self.depth_mm is None and self.force_n is None:
            yield "depth_mm is missing: a touch needs depth_mm, force_n, or both"
        lowest = self.force_n.lowest if isinstance(self.force_n, Distribution) else self.force_n
        if lowest is not None and lowest <= 0:
            yield f"force_n = {lowest:g} is not allowed: must be above 0"

    def keyframes(self, drawn: dict[str, float]) -> list[Table]:
        """Keyframes of the drawn path, with the depth at which it ends in any case."""
        turn, slide = math.radians(drawn["shear_direction_deg"]), drawn["shear_mm"]
        place = {"x_mm": drawn["x_mm"], "y_mm": drawn["y_mm"]}
        slid, turned = place, {}
        if self.shear_frames:
            slid = {"x_mm": place["x_mm"] + slide * math.cos(turn), "y_mm": place["y_mm"] + slide * math.sin(turn)}
        if self.twist_frames:
            turned = {"twist_deg": drawn["twist_deg"]}
        far, pressed = {"gap_mm": drawn["gap_mm"]}, {"gap_mm": -drawn["depth_mm"]}
        begin = [
            (0, place | far),
            (self.approach_frames, place | {"gap_mm": min(TOUCHING_MM, drawn["gap_mm"])}),
            (self.press_frames, place | pressed),
        ]
        if not self.approach_frames:
            first = {"gap_mm": -drawn["depth_mm"] / self.press_frames}
            begin = [(0, place | first), (self.press_frames - 1, place | pressed)]
        return _timed(
            [
                *begin,
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


def _timed(steps: list[tuple[int, Table]]) -> list[Table]:
    """Keyframes from durations [frames] and states; all but the first of no duration are left out."""
    frame, result = 0, [{"frame": 0, **steps[0][1]}]
    for frames, state in steps[1:]:
        if frames:
            frame += frames
            result.append({"frame": frame, **state})
    return result
