"""A room that is near: what shines from all around stands on a sphere around the middle of the contact face.

A ray then sees what is where it leaves the sphere, and not what is in its direction: nearby places look at different
parts of the picture, as they do before a bench or a wall. The sphere is matt: each of its places sends the same
radiance everywhere. Nothing stands outside of it (`magicsim.scenes.near_room`), so a line has one place where its light
comes from, wherever on it a ray begins.
"""

from typing import Any

from magicsim.light.backend import dr, mi
from magicsim.scenes.rig import Rig


def missed(ray: Any) -> Any:
    """What rays are said to meet that meet nothing, for whatever shines from all around: their origin and direction."""
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.p, si.wi = ray.o, -ray.d
    return si


class NearRoom:
    """Light from all around, from a sphere; asked as environments are, with the origins of the rays."""

    def __init__(self, far: Any, distance_mm: float) -> None:
        """Puts it there.

        Args:
            far: Emitter that shines from infinitely far away.
            distance_mm: Radius of the sphere [mm].
        """
        self._far, self._distance = far, dr.opaque(mi.Float, distance_mm)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Radiance that arrives at `si.p` along `-si.wi`, mi.Color3f; 0 on lines that pass by the sphere.

        Args:
            si: See `missed`.
            active: Which rays count.
        """
        ahead = dr.dot(si.p, si.wi)
        inside = dr.square(self._distance) - dr.squared_norm(si.p - ahead * si.wi)
        place = si.p - (ahead + dr.safe_sqrt(inside)) * si.wi
        seen = active & (inside > 0)
        met = dr.zeros(mi.SurfaceInteraction3f)
        met.wi = -dr.normalize(place)
        return dr.select(seen, self._far.eval(met, seen), 0)


def surroundings(far: Any, rig: Rig) -> Any:
    """What shines from all around, from as near as a rig says; None where nothing does.

    Args:
        far: Emitter that shines from infinitely far away, or None.
        rig: Has the distance.
    """
    return far if far is None or rig.near_mm is None else NearRoom(far, rig.near_mm)


class RoomPicture(mi.Texture):  # type: ignore[misc]
    """Radiance of the sphere for Mitsuba's own integrators, which meet it as a shape."""

    def __init__(self, properties: Any) -> None:
        """Reads `far`, an emitter that shines from infinitely far away."""
        super().__init__(properties)
        self._far, self._scale = properties["far"], mi.Float(1)

    def traverse(self, callback: Any) -> None:
        """Shows a factor to `mi.traverse`."""
        callback.put("value", self._scale, mi.ParamFlags.Differentiable)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Radiance of places on the sphere."""
        met = dr.zeros(mi.SurfaceInteraction3f)
        met.wi = -dr.normalize(si.p)
        return self._scale * self._far.eval(met, active)

    def to_string(self) -> str:
        """One line for logs."""
        return "RoomPicture[]"


mi.register_texture("room_picture", RoomPicture)


def room_sphere(far: dict[str, Any], distance_mm: float) -> dict[str, Any]:
    """Entry of the sphere in a scene's dictionary, black and bright inside.

    Args:
        far: Entry of the emitter that shines from infinitely far away.
        distance_mm: Radius [mm].
    """
    return {
        "type": "sphere",
        "radius": distance_mm,
        "flip_normals": True,
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        "emitter": {"type": "area", "radiance": {"type": "room_picture", "far": far}},
    }
