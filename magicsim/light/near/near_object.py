"""An object before the untouched block in a scene of its own, moved as a whole: no search tree is built anew."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index, Mask, Numbers
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.pose import Pose
from magicsim.light.backend import dr, floats, in_rows, mi, pointer
from magicsim.light.near.ports import Ports
from magicsim.light.records.recorded_paths import RecordedPaths, escaped, mirror_samples
from magicsim.light.transport.path_starts import ObjectRays, object_rays
from magicsim.light.transport.recorded_light import RecordedLight
from magicsim.light.world.finish import Finish
from magicsim.light.world.irradiance import IrradianceKernel, blended_kernel
from magicsim.light.world.medium import leave
from magicsim.light.world.names import OBJECT, PLACE
from magicsim.light.world.room_light import missed
from magicsim.light.world.scene_dict import in_group
from magicsim.light.world.shapes import mesh_shape

FAR_MM = 5.0
"""Gap from which pixels look at the object along all their rays."""
DIGITS = 6
"""Decimals of heights on the object [mm], so that its places along z share kernels."""
PORTS_MM = 2.0
"""Gap up to which the strips' light comes from ports alone; beyond, the more by recorded particles the wider the gap
[mm]. Close by these are the noisier, far away directions of ports are coarse (`benchmarks/frame_error.py`)."""


@dataclass(slots=True, kw_only=True)
class NearObject:
    """One object; what it is asked for holds where it was last put. Takes the place of `Outside` for recorded rays."""

    mesh: SurfaceMesh
    finish: Finish
    scene: Any
    parameters: Any
    object: Any
    """Shape of the object."""
    joined: Any = None
    """A scene that holds the block as well: none, see `Outside`."""
    placed: SurfaceMesh | None = None
    """Surface of the object in the sensor's frame."""

    @classmethod
    def of(cls, mesh: SurfaceMesh, finish: Finish) -> Self:
        """Loads it where its own frame puts it."""
        shape = mesh_shape(mesh, OBJECT, finish.bsdf())
        scene = mi.load_dict({"type": "scene", **in_group({OBJECT: shape})}, optimize=False)
        return cls(mesh=mesh, finish=finish, scene=scene, parameters=mi.traverse(scene), object=shape)

    @property
    def matt(self) -> Finish:
        """Surface of the object as if it sent out all that it mirrors alike in all directions."""
        own, mirrored = self.finish, self.finish.specular
        red, green, blue = (mirrored + (1 - mirrored) * each for each in own.color)
        return replace(own, specular=0.0, color=(red, green, blue))

    def place(self, pose: Pose) -> None:
        """Puts the object there."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.position_mm
        self.parameters[f"{PLACE}.to_world"] = mi.Transform4f(matrix)
        self.parameters.update()
        self.placed = SurfaceMesh(vertices=pose.to_sensor(self.mesh.vertices), faces=self.mesh.faces)

    def look(
        self, block: Any, room: Any, ports: Ports, lines: Any, behind: Array, light: RecordedLight, *, rays: int,
        seed: int,
    ) -> "Seen":  # fmt: skip
        """What the object's own rays, lines from the face, and particles that left the block meet.

        Args:
            block: The sensor's scene, with nothing before it.
            room: What shines from all around in this frame, or None.
            ports: Of the light that leaves the face.
            lines: Lines from the face, mi.Ray3f.
            behind: Radiance of the room that comes along these where no object is, shape (lines, 3).
            light: Of the strips, that left the untouched block.
            rays: Rays from the object's surface.
            seed: Of their pattern.
        """
        assert self.placed is not None
        sent = object_rays(self.placed, rays, seed=seed)
        count = len(sent.triangle)
        origins, ways = (
            [dr.concat([one, two]) for one, two in zip(first, second, strict=True)]
            for first, second in ((sent.rays.o, lines.o), (sent.rays.d, lines.d))
        )
        both = mi.Ray3f(mi.Point3f(*origins), mi.Vector3f(*ways))
        number, triangle, share, now, free = _met(self.scene, pointer(self.object), block, room, self.matt, ports, both)
        areas = np.bincount(sent.triangle, sent.area_mm2, len(self.mesh.faces))
        kernel = self._blended(self.placed)
        return Seen(
            number=number[:count], triangle=triangle, share=share, now=now[:count], behind=behind,
            free=free[:count], sent=sent, kernel=kernel, spread_mm2=kernel.spread(areas[:, None].astype(np.float32)),
            strips=self._by_particles(light, kernel),
        )  # fmt: skip

    def mirrored(
        self, block: Any, room: Any, ports: Ports, shining: Array, irradiance: Array, paths: RecordedPaths,
        pixels: Numbers, *, seed: int,
    ) -> Array:  # fmt: skip
        """Radiance that some pixels get by way of the object's mirror, shape (pixels, 3).

        Args:
            block: The sensor's scene, with nothing before it.
            room: What shines from all around, or None.
            ports: Of the light that leaves the face.
            shining: Radiance of these, shape (ports, 3).
            irradiance: Of the object, shape (triangles, 3).
            paths: Of the pixels; each of their rays is mirrored once.
            pixels: Numbers of the pixels, row by row of the film.
            seed: Of the mirror's facets.
        """
        if not len(paths.owner):
            return np.zeros((len(pixels), 3))
        out, lit = (floats(each) for each in (shining, irradiance))
        met = _mirrored(
            self.scene, block, room, pointer(self.object), self.finish, ports.met, out, lit, paths.rays,
            *paths.rays_of(pixels), dr.opaque(mi.UInt64, seed),
        )  # fmt: skip
        return in_rows(met)

    @property
    def is_far(self) -> bool:
        """Whether it is so far away that few of a pixel's rays meet it."""
        return self.placed is not None and float(self.placed.vertices[:, 2].max()) < -FAR_MM

    @property
    def from_ports(self) -> float:
        """Share of the strips' light that it gets from ports."""
        assert self.placed is not None
        return min(1.0, PORTS_MM / max(PORTS_MM, -float(self.placed.vertices[:, 2].max())))

    def _by_particles(self, light: RecordedLight, kernel: IrradianceKernel) -> Array:
        """Irradiance by recorded particles, shape (triangles, 3)."""
        share, triangles = 1 - self.from_ports, len(self.mesh.faces)
        if share == 0:
            return np.zeros((triangles, 3))
        si = self.scene.ray_intersect_preliminary(light.rays)
        met = np.array(si.is_valid())
        triangle, weights = np.array(si.prim_index)[met], in_rows(light.weights)[met].T
        flux = [np.bincount(triangle, each, triangles) for each in weights]
        landed = np.stack([*flux, light.particles * kernel.areas_mm2], 1).astype(np.float32)
        return share * _mean(*np.split(kernel.spread(landed), [3], 1))

    def _blended(self, placed: SurfaceMesh) -> IrradianceKernel:
        """Kernel that is the wider the further a triangle is from the face.

        Of the gap it knows the power of two below, none below `PORTS_MM`, so that frames of an approach share it.
        """
        heights = placed.vertices[:, 2]
        gap_mm = np.round(-heights.max(), DIGITS)
        gap_mm = 2 ** np.floor(np.log2(gap_mm)) if gap_mm >= PORTS_MM else 0.0
        away_mm = gap_mm + np.round(heights.max() - heights[placed.faces].mean(1), DIGITS)
        return blended_kernel(self.mesh, away_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What rays from an object, and then lines from the face, meet."""

    number: Index
    """The port that each place on the object looks at, the number of all where none is there."""
    triangle: Index
    """The object's triangle that each ray meets; -1 where it meets none."""
    share: Array
    """What that sends out for each unit of irradiance, shape (rays, 3)."""
    now: Array
    """Radiance of the room behind everything along the object's rays, shape (object's rays, 3)."""
    behind: Array
    """That along the lines, where no object is, shape (lines, 3)."""
    free: Mask
    """Which of the object's rays meet nothing."""
    sent: ObjectRays
    kernel: IrradianceKernel
    spread_mm2: npt.NDArray[np.floating[Any]]
    """Area that the object's rays stand for, spread by the kernel over its triangles, shape (triangles, 1) [mm2]."""
    strips: Array
    """Irradiance by recorded particles, shape (triangles, 3)."""

    def irradiance(self, shining: Array, own: Array) -> Array:
        """Irradiance of the object, shape (triangles, 3).

        Args:
            shining: Radiance of the ports without what particles stand for, shape (ports, 3).
            own: The object's irradiance before, of the same shape as the result.
        """
        count = len(self.number)
        met = self.now * self.free[:, None]
        met += np.concatenate([shining, np.zeros((1, 3))])[self.number] + self._sent_out(own)[:count]
        met *= np.pi * self.sent.area_mm2[:, None]
        flux = np.zeros(self.strips.shape, np.float32)
        for channel in range(3):
            flux[:, channel] = np.bincount(self.sent.triangle, met[:, channel], len(flux))
        return self.strips + _mean(self.kernel.spread(flux), self.spread_mm2)

    def changes(self, own: Array, passed: Array) -> Array:
        """What changes of the radiance that comes along the face's lines, shape (lines, 3).

        Args:
            own: The object's irradiance, shape (triangles, 3).
            passed: What passes changes where a line meets no object, shape (lines, 3).
        """
        on_object = self.triangle[len(self.number) :, None] >= 0
        return np.where(on_object, self._sent_out(own)[len(self.number) :] - self.behind, passed)

    def _sent_out(self, own: Array) -> Array:
        return self.share * own[self.triangle]


def _mean(flux: npt.NDArray[Any], areas_mm2: npt.NDArray[Any]) -> Array:
    """Flux by area, 0 where there is none."""
    return np.asarray(np.divide(flux, areas_mm2, out=np.zeros(flux.shape), where=areas_mm2 > 0))


def _met(scene: Any, shape: Any, block: Any, room: Any, finish: Finish, ports: Ports, rays: Any) -> tuple[Any, ...]:
    """What rays meet, as the first fields of `Seen`."""
    si = scene.ray_intersect(rays)
    own = si.is_valid() & (si.shape == shape)
    number, found = ports.met(rays)
    number = dr.select(found & ~own, number, ports.count)
    triangle = dr.select(own, mi.Int32(si.prim_index), -1)
    share = dr.select(own, finish.diffuse(si, own), 0)
    dr.eval(own, number, triangle, share)
    free = ~own & (number == ports.count) & ~block.ray_intersect_preliminary(rays).is_valid()
    return (
        np.array(number), np.array(triangle), in_rows(share), radiance_of(room, rays), np.array(free),
    )  # fmt: skip


def radiance_of(room: Any, rays: Any) -> Array:
    """What shines along rays from all around, shape (rays, 3); nothing for None."""
    return in_rows(room.eval(missed(rays))) if room is not None else np.zeros((dr.width(rays), 3))


@dr.syntax  # type: ignore[untyped-decorator]
def _mirrored(
    scene: Any, block: Any, room: Any, shape: Any, finish: Finish, port: Any, out: Any, lit: Any, rays: Any, begin: Any,
    end: Any, seed: Any,
) -> Any:  # fmt: skip
    """Sum over each pixel's rays of what the object mirrors along them: ports, the room, and the object itself."""
    number, radiance = mi.UInt32(begin), mi.Color3f(0.0)
    while number < end:
        ray, weight = escaped(rays, number)
        si = scene.ray_intersect(ray)
        on_object = si.is_valid() & (si.shape == shape)
        direction, share = finish.mirror(si, mirror_samples(number, seed)[0])
        back = leave(si, si.to_world(direction))
        again = scene.ray_intersect(back, on_object)
        itself = again.is_valid() & (again.shape == shape)
        place, found = port(back)
        inward, free = on_object & found & ~itself, on_object & ~found & ~itself
        met = mi.Color3f(*[dr.gather(mi.Float, out, 3 * place + channel, inward) for channel in range(3)])
        flux = mi.Color3f(*[dr.gather(mi.Float, lit, 3 * again.prim_index + channel, itself) for channel in range(3)])
        met += dr.select(itself, flux * finish.diffuse(again, itself), 0)
        if room is not None:
            free &= ~block.ray_intersect_preliminary(back, False, free).is_valid()
            met += dr.select(free, room.eval(missed(back), free), 0)
        radiance += dr.select(on_object, weight * share * met, 0)
        number += 1
    return radiance
