"""The fluence estimator as a Mitsuba integrator, so that `mi.render(scene)` is all that a user needs."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.camera.window import Window
from magicsim.light.aligned import aligned
from magicsim.light.backend import dr, mi
from magicsim.light.transport.cached_light import CachedLight, Elements, Piecewise, VoxelField, cell_slopes
from magicsim.light.transport.camera_pass import gather_radiance
from magicsim.light.transport.integrator_settings import read_medium, read_triple
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.light_pass import FIXED_POINT, Tracks, deposit_tracks, sum_tracks
from magicsim.light.transport.light_starts import ROOM_PART, ROUND_OBJECT, LightStarts, Sent, chunks
from magicsim.light.transport.object_light import object_rays
from magicsim.light.transport.path_record import PathRecord
from magicsim.light.transport.path_starts import CameraStarts, PathStarts
from magicsim.light.transport.recorded_light import LightRecord
from magicsim.light.transport.streams import ON_OBJECT, ROOM_ON_OBJECT, SEEDS_PER_RENDER
from magicsim.light.transport.voxels import BodyPart, Voxels
from magicsim.light.world.finish import Finish
from magicsim.light.world.inventory import Inventory, beams_of, emitter_of, light_names
from magicsim.light.world.medium import Media
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT
from magicsim.light.world.outside import Outside
from magicsim.light.world.shapes import Shapes

FloatArray = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.uint32]
LIGHT_DEPTH = 2000
"""Longest light path [interactions], and as many more as light needs to diffuse through the block. Roulette ends those
of the default sensor before 400; so short, they leave the white furnace of an infill of index 1 0.3 % too dark."""
DIFFUSION = 3.0
"""Collisions to diffuse across a block, in units of its scattering times its reduced scattering depth."""
CAMERA_DEPTH = 200
"""Longest camera path [interactions], below `path_record.STEPS`; roulette ends those of the default sensor before."""
FLASHLIGHT_PART = 4
"""A flashlight on no object gets the strips' particles divided by this: the image's error stays the same."""
RAYS_PER_PARTICLE = 0.5
"""Rays from the object for each particle of the light pass."""


class FluenceIntegrator(mi.CppADIntegrator):  # type: ignore[misc]
    """Cached-fluence rendering of a scattering grid in a clear or scattering body.

    Unbiased for isotropic scattering in the limit of small cells and many particles. Scene requirements: a shape
    `body`, and a shape `infill` of disjoint cells, x fastest, with `triangles_per_cell` triangles each.
    """

    def __init__(self, properties: Any) -> None:
        """Reads `particles`, and the rest as `integrator_settings` writes it."""
        super().__init__(properties)
        self.particles = properties.get("particles", 200_000)
        self.finish = Finish(
            color=tuple(properties.get("object_color", mi.ScalarColor3f(0.5))),
            vertex_colors=properties.get("object_vertex_colors", False),
            specular=properties.get("object_specular", 0.0),
            roughness=properties.get("object_roughness", 0.2),
        )
        self.inside = frozenset(properties.get("lights_inside", "").split(","))
        self.off = frozenset(properties.get("lights_off", "").split(","))
        self.inventory = Inventory(properties.get("triangles_per_cell", 12))
        self.followed_media = Media(
            body_ior=properties["body_ior"],
            infill_ior=properties["infill_ior"],
            body=read_medium(properties, "body").reduced,
            infill=read_medium(properties, "infill"),
            top_mm=properties["top_mm"],
            skin_roughness=properties.get("skin_roughness", 0.0),
            wall_roughness=properties.get("wall_roughness", 0.0),
        )
        self.followed = properties.get("forward_collisions", 0)
        if self.followed_media.infill.anisotropy == 0:
            self.followed = 0
        self.media = replace(self.followed_media, infill=self.followed_media.infill.reduced)
        self.counts = read_triple(properties, "cells", int)
        self.voxels: Voxels | None = None
        if self.media.body.sigma_s > 0:
            self.voxels = Voxels(
                origin_mm=read_triple(properties, "voxel_origin"),
                size_mm=read_triple(properties, "voxel_size"),
                counts=read_triple(properties, "voxels", int),
            )

    def render(
        self,
        scene: Any,
        sensor: Any = 0,
        seed: int = 0,
        spp: int = 0,
        develop: bool = True,
        evaluate: bool = True,
    ) -> Any:
        """Renders the scene's first sensor; returns a tensor of shape (rows, columns, 3)."""
        fields = self.light_fields(scene, self.shares(scene), seed=seed)
        field = self.with_lit_object(
            scene, total([self.darkness(scene), *fields.values()]), particles=self.particles, seed=seed
        )
        return self.gather(scene, field, samples=spp or 16, seed=seed)

    def darkness(self, scene: Any, outside: Outside | None = None) -> LightField:
        """The light field of a scene without lights, and of what stands outside."""
        shapes = self.inventory.shapes(scene, outside)
        return LightField(
            fluence=np.zeros((shapes.cells, 3)),
            body=np.zeros((self.voxels.count if self.voxels is not None else 1, 3)),
            irradiance=np.zeros((shapes.object_triangles, 3)),
        )

    def shares(self, scene: Any, outside: Outside | None = None) -> dict[str, int]:
        """Particles of each light: all strips together get `particles`, the room and a flashlight alone fewer."""
        names = light_names(scene, outside)
        strips = sum(name not in {FLASHLIGHT, ENVIRONMENT} for name in names)
        each = max(1, self.particles // max(1, strips))
        alone = self.inventory.shapes(scene, outside).object is None
        part = FLASHLIGHT_PART if alone else 1
        outer = {FLASHLIGHT: max(1, self.particles // part), ENVIRONMENT: max(1, self.particles // ROOM_PART)}
        return {name: outer.get(name, each) for name in names}

    def light_fields(
        self, scene: Any, particles: Mapping[str, int], *, seed: int, outside: Outside | None = None,
        record: LightRecord | None = None,
    ) -> dict[str, LightField]:  # fmt: skip
        """Light that emitters bring to every cell and to the object, by name.

        Args:
            scene: The loaded scene.
            particles: Number of particles of each light, all or some of `light_names(scene, outside)`.
            seed: Seed of the render; every light has a stream of its own.
            outside: What stands before the block in a scene of its own.
            record: Takes down what leaves, or None.
        """
        shapes = self.inventory.shapes(scene, outside)
        scatters = self.voxels is not None or (shapes.infill is not None and self.media.infill.sigma_s > 0)
        dark, lit = self.darkness(scene, outside), {name: particles[name] for name in particles if name not in self.off}
        if not lit or (shapes.object is None and not scatters and record is None):
            return dict.fromkeys(particles, dark)
        volumes = self.inventory.volumes_mm3(scene)
        sent = [
            each
            for place, (name, count) in enumerate(lit.items())
            for each in self.sent(scene, name, count, seed=seed, place=place, outside=outside)
        ]
        tracks = sum_tracks(
            [
                self.light_pass(scene, shapes, LightStarts.emitted(chunk), lights=len(lit), record=record)
                for chunk in chunks(sent)
            ]
        )
        scales = 1 / (FIXED_POINT * np.array(list(lit.values()), float)[:, None, None])
        landed = np.concatenate(list(tracks.landed * scales), 1)
        # One product for all lights: reading the kernel costs more than using it.
        irradiance = self.inventory.irradiance(scene, shapes, landed)
        fluence, body = tracks.cells * scales / volumes, tracks.body * scales
        return dict.fromkeys(particles, dark) | {
            name: LightField(
                fluence=fluence[place], body=body[place], irradiance=irradiance[:, 3 * place : 3 * place + 3]
            )
            for place, name in enumerate(lit)
        }

    def sent(
        self, scene: Any, name: str, count: int, *, seed: int, place: int = 0, outside: Outside | None = None
    ) -> list[Sent]:
        """What one light sends out: the room one beam, and a second one with fewer particles around an object.

        Args:
            scene: The loaded scene.
            name: Of the light, one of `light_names(scene, outside)`.
            count: Its particles; flux is in units of one over their number.
            seed: Seed of the render.
            place: Number of the light among all that are traced.
            outside: What stands before the block in a scene of its own.
        """
        emitter, stream = emitter_of(scene, name, outside), self.stream(scene, name, seed, outside)
        first = Sent(emitter, 0, count, stream, name in self.inside, place)
        if name != ENVIRONMENT:
            return [first]
        beams = beams_of(scene, outside)
        fewer = max(1, round(ROUND_OBJECT * count))
        around = first._replace(particles=fewer, seed=SEEDS_PER_RENDER * seed + ROOM_ON_OBJECT, weight=count / fewer)
        return [each._replace(beam=beam) for each, beam in zip((first, around), beams, strict=False)]

    def with_lit_object(
        self, scene: Any, field: LightField, *, particles: int, seed: int, outside: Outside | None = None,
        room: Any = None,
    ) -> LightField:  # fmt: skip
        """The field with the irradiance of the object gathered by rays from its surface, see `object_light`.

        Args:
            scene: The loaded scene.
            field: Of all lights that shine.
            particles: Of the light pass: as many rays serve the object as `RAYS_PER_PARTICLE` says.
            seed: Seed of the render.
            outside: What stands before the block in a scene of its own.
            room: What alone shines, see `Shapes`.
        """
        shapes = replace(self.inventory.shapes(scene, outside), room=room)
        if shapes.object is None:
            return field
        stream = SEEDS_PER_RENDER * seed + ON_OBJECT
        sent = object_rays(scene, shapes, max(1, round(RAYS_PER_PARTICLE * particles)), seed=stream)
        met = np.array(self.camera_pass(scene, shapes, field, sent.starts, self.finish, stream=stream), np.float64)
        count = shapes.object_triangles
        weights = [np.pi * sent.area_mm2 * channel for channel in met]
        flux = np.stack([np.bincount(sent.triangle, weight, count) for weight in weights], 1).astype(np.float64)
        areas = np.bincount(sent.triangle, sent.area_mm2, count).astype(np.float64)
        gathered = self.inventory.gathered_irradiance(scene, shapes, flux, areas, field.irradiance)
        return replace(field, irradiance=gathered)

    def held_mm3(self, scene: Any) -> FloatArray:
        """Volume of the body in each voxel, shape (voxels, 1), 0 where it is next to nothing; 1 where it is clear."""
        if self.voxels is None:
            return np.ones((1, 1))
        return self.voxels.body_part(scene, self.inventory.shapes(scene)).held_mm3[:, None]

    def light_pass(
        self, scene: Any, shapes: Shapes, starts: LightStarts, *, lights: int = 1, record: LightRecord | None = None
    ) -> Tracks:
        """What particles leave behind.

        Args:
            scene: The loaded scene.
            shapes: Its shapes by their role.
            starts: Where the particles start.
            lights: Number of lights.
            record: Takes down what leaves, or None.
        """
        media = self.followed_media if self.followed else self.media
        tracks: Tracks = deposit_tracks(
            scene, starts, shapes, media, self.voxels, lights=lights, max_depth=self.light_depth(media), balance=False,
            record=record,
        )  # fmt: skip
        return tracks

    def stream(self, scene: Any, name: str, seed: int, outside: Outside | None = None) -> int:
        """Random stream of a light."""
        return SEEDS_PER_RENDER * seed + 1 + light_names(scene, outside).index(name)

    def balance(self, scene: Any, name: str, *, particles: int, seed: int) -> dict[str, float]:
        """Where the flux of one light goes, summed over channels: `emitted`, `absorbed`, `escaped`, and `ended`.

        The last is what ended paths still carried less what roulette gave to others, zero in the mean.

        Args:
            scene: The loaded scene.
            name: One of `light_names(scene, outside)`.
            particles: Number of particles, traced at once.
            seed: Random stream.
        """
        starts = LightStarts.emitted([each._replace(seed=seed) for each in self.sent(scene, name, particles, seed=0)])
        tracks = deposit_tracks(
            scene, starts, self.inventory.shapes(scene), self.media, self.voxels, lights=1,
            max_depth=self.light_depth(self.media), balance=True, record=None,
        )  # fmt: skip
        account, media = tracks.balance, self.media
        scattered = media.infill.sigma_a * tracks.cells.sum() + media.body.sigma_a * tracks.body.sum()
        absorbed = scattered / FIXED_POINT + account.clear_body.sum() + account.surfaces.sum()
        return {
            "emitted": float(account.emitted.sum()),
            "absorbed": float(absorbed),
            "escaped": float(account.escaped.sum()),
            "ended": float(account.ended.sum()),
        }

    def light_depth(self, media: Media) -> int:
        """Longest path through media that are followed as they are given [interactions]."""
        depths = [medium.sigma_s * medium.reduced.sigma_s * media.top_mm**2 for medium in (media.body, media.infill)]
        return int(LIGHT_DEPTH + DIFFUSION * max(depths))

    def gather(
        self, scene: Any, field: LightField, *, samples: int, seed: int, pattern: int = 0, window: Window | None = None
    ) -> Any:
        """Radiance of a window of the film from cached light, a tensor of shape (rows, columns, 3)."""
        columns, rows = (int(size) for size in scene.sensors()[0].film().size())
        window = window or Window.whole(columns, rows)
        pixels = window.numbers(columns, rows)
        seen = self.gather_pixels(scene, field, pixels, samples=samples, seed=seed, pattern=pattern)
        return mi.TensorXf(dr.ravel(seen), shape=(window.rows, window.columns, 3))

    def gather_pixels(
        self, scene: Any, field: LightField, pixels: Numbers, *, samples: int, seed: int, pattern: int = 0,
        room: Any = None,
    ) -> Any:  # fmt: skip
        """Radiance of some pixels of the film from cached light, mi.Color3f.

        Args:
            scene: The loaded scene.
            field: Cached light.
            pixels: Numbers of the pixels, row by row of the film.
            samples: Camera samples of each.
            seed: Seed of the render.
            pattern: Number of the pattern of samples.
            room: What alone shines, see `Shapes`.
        """
        shapes = replace(self.inventory.shapes(scene), room=room)
        starts = CameraStarts.of(
            scene.sensors()[0], samples=samples, pixels=pixels, pattern=pattern, part=range(samples)
        )
        return self.camera_pass(scene, shapes, field, starts, self.finish, stream=SEEDS_PER_RENDER * seed) / samples

    def camera_pass(
        self, scene: Any, shapes: Shapes, field: LightField, starts: PathStarts, finish: Finish, *, stream: int,
        record: PathRecord | None = None,
    ) -> Any:  # fmt: skip
        """Radiance summed over each lane's paths, mi.Color3f.

        Args:
            scene: The loaded scene.
            shapes: Its shapes by their role.
            field: Cached light.
            starts: Where the paths start.
            finish: Surface of the object.
            stream: Random stream.
            record: Takes down what the paths pass, or None.
        """
        return gather_radiance(
            scene, shapes, self.media, self._cached(scene, shapes, field), finish, starts, seed=stream,
            max_depth=CAMERA_DEPTH, forward=self.followed_media.infill if self.followed else None,
            followed=self.followed, record=record,
        )  # fmt: skip

    def elements(self, scene: Any, field: LightField) -> Elements:
        """Light in the cells and then in the voxels of a body that scatters, as camera paths look it up.

        Args:
            scene: The loaded scene.
            field: Cached light, or what changes of it: all is linear in it.
        """
        shapes = self.inventory.shapes(scene)
        parts = [self._cells(scene, shapes, field)]
        if self.voxels is not None:
            parts.append(_body_elements(self.voxels, self.voxels.body_part(scene, shapes), field))
        return Elements(*(np.concatenate(each) for each in zip(*parts, strict=True)))

    def _cells(self, scene: Any, shapes: Shapes, field: LightField) -> Elements:
        centres, slopes = np.zeros((shapes.cells, 3)), np.zeros((shapes.cells, 3, 3))
        grid = self.inventory.grid(scene)
        if grid is not None and np.prod(self.counts) == shapes.cells:
            centres = grid.centres_mm
            slopes = cell_slopes(field.fluence, centres, self.counts)
        return Elements(field.fluence, slopes, centres)

    def _cached(self, scene: Any, shapes: Shapes, field: LightField) -> CachedLight:
        body, is_change = None, shapes.room is not None
        if self.voxels is not None:
            part = self.voxels.body_part(scene, shapes)
            body = VoxelField(voxels=self.voxels, field=_piecewise(_body_elements(self.voxels, part, field), is_change))
        cells = _piecewise(self._cells(scene, shapes, field), is_change)
        return CachedLight(cells=cells, body=body, irradiance=_flat(field.irradiance))

    def to_string(self) -> str:
        """One line for logs."""
        return f"FluenceIntegrator[particles={self.particles}]"


def _flat(values: FloatArray) -> Any:
    return mi.Float(aligned(values, np.float32).ravel())


def _piecewise(elements: Elements, is_change: bool) -> Piecewise:
    values, slopes, centres = (_flat(each) for each in elements)
    return Piecewise(values=values, slopes=slopes, centres=centres, is_change=is_change)


def _body_elements(voxels: Voxels, part: BodyPart, field: LightField) -> Elements:
    held = part.held_mm3[:, None]
    fluence = np.divide(field.body, held, out=np.zeros_like(field.body), where=held > 0)
    slopes, inner = np.zeros((len(fluence), 3, 3)), voxels.inner
    slopes[inner] = cell_slopes(fluence[inner], part.centres_mm[inner], voxels.inner_counts)
    return Elements(fluence, slopes, part.centres_mm)


mi.register_integrator("fluence", FluenceIntegrator)
