"""What something that passes changes of the room's radiance: its own in front of it, less that of what it hides.

The change has either sign, so it is no light that the renderer knows. It is asked for the radiance of directions, as
an environment is, and sends particles of its positive and of its negative part.
"""

from typing import Any, NamedTuple

from magicsim.light.backend import dr, mi
from magicsim.light.world.room_light import Beam, beam_rays, room_towards
from magicsim.scenes.room import Passing

SOFT = 0.2
"""Part of half its width and height over which its edges fade."""


class PassingLight:
    """The change of the room by something that can be moved."""

    def __init__(self, passing: Passing, room: Any, ambient: tuple[float, float, float]) -> None:
        own = [share * light for share, light in zip(passing.reflectance, ambient, strict=True)]
        self._room, self._color = room, mi.Color3f(*(dr.opaque(mi.Float, each) for each in own))
        numbers = (passing.distance_mm, passing.rise_mm, *(size / 2 for size in passing.size_mm))
        self._distance, self._rise, self._half_width, self._half_height = (dr.opaque(mi.Float, n) for n in numbers)
        self._place = dr.opaque(mi.Float, 0.0)

    def place(self, x_mm: float) -> None:
        """Moves its middle along x [mm]."""
        self._place = dr.opaque(mi.Float, x_mm)

    def eval(self, si: Any, active: Any = True) -> Any:
        """Change of the radiance that arrives along `-si.wi`, mi.Color3f."""
        towards = -si.wi
        far = self._distance / dr.maximum(-towards.z, 1e-6)
        across = (far * towards.x - self._place) / self._half_width
        up = (far * towards.y - self._rise) / self._half_height
        covered = dr.select(towards.z < 0, _faded(across) * _faded(up), 0)
        seen = active & (covered > 0)
        return dr.select(seen, covered * (self._color - self._room.eval(si, seen)), 0)

    def rays(self, beam: Beam, u: list[Any]) -> tuple[Any, Any]:
        """First rays of particles, evenly over it, and their weights of either sign; `u` is uniform."""
        x = self._place + (2 * u[0] - 1) * self._half_width
        y = self._rise + (2 * u[1] - 1) * self._half_height
        way = mi.Vector3f(-x, -y, self._distance)
        squared = dr.squared_norm(way)
        way = way * dr.rsqrt(squared)
        solid_angle = 4 * self._half_width * self._half_height * self._distance * dr.rcp(squared * dr.sqrt(squared))
        ray, area = beam_rays(beam, way, u[2], u[3])
        weight = mi.Color3f(room_towards(self, ray)) * (area * solid_angle)
        if beam.leaves_out is not None:
            weight[beam.leaves_out.has(ray)] = 0
        return ray, weight


def _faded(share: Any) -> Any:
    """1 in the middle, 0 from 1 on, smooth between."""
    t = dr.clip((1 - dr.abs(share)) / SOFT, 0, 1)
    return t * t * (3 - 2 * t)


class PassingPart(NamedTuple):
    """The part of one sign."""

    light: PassingLight
    sign: float

    def rays(self, beam: Beam, u: list[Any]) -> tuple[Any, Any]:
        """See `PassingLight.rays`; weights of the other sign are 0."""
        ray, weight = self.light.rays(beam, u)
        return ray, mi.Color3f(dr.maximum(self.sign * weight, 0))
