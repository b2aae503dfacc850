"""The fluence estimator as a Mitsuba integrator, so that `mi.render(scene)` is all that a user needs."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.scenes.backend import dr, mi
from magicsim.scenes.cached_light import CachedLight, Piecewise, VoxelField, cell_slopes
from magicsim.scenes.camera_pass import gather_radiance
from magicsim.scenes.finish import Finish
from magicsim.scenes.integrator_settings import read_medium, read_triple
from magicsim.scenes.inventory import Inventory, emitter_of, light_names
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.light_pass import FIXED_POINT, Tracks, deposit_tracks, sum_tracks
from magicsim.scenes.light_starts import EmitterStarts, LightStarts, emitter_chunks
from magicsim.scenes.medium import Media
from magicsim.scenes.names import ENVIRONMENT, FLASHLIGHT
from magicsim.scenes.outside import Outside
from magicsim.scenes.path_record import PathRecord
from magicsim.scenes.path_starts import CameraStarts, PathStarts
from magicsim.scenes.recorded_light import LightRecord
from magicsim.scenes.shapes import Shapes
from magicsim.scenes.voxels import BodyPart, Voxels
from magicsim.scenes.window import Window

FloatArray = npt.NDArray[np.float64]
LIGHT_DEPTH = 2000
"""Longest light path [interactions], and as many more as light needs to diffuse through the block. Roulette ends those
of the default sensor before 400; so short, they leave the white furnace of an infill of index 1 0.3 % too dark."""
DIFFUSION = 3.0
"""Collisions to diffuse across a block, in units of its scattering times its reduced scattering depth."""
CAMERA_DEPTH = 200
"""Longest camera path [interactions], below `path_record.STEPS`; roulette ends those of the default sensor before."""
FLASHLIGHT_PART = 4
"""A flashlight on no object gets the strips' particles divided by this: the image's error stays the same."""
SEEDS_PER_RENDER = 64
"""Random streams that one seed owns: the camera's, one a light, and those of `untouched_passes`."""


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
        return self.gather(scene, total([self.darkness(scene), *fields.values()]), samples=spp or 16, seed=seed)

    def darkness(self, scene: Any, outside: Outside | None = None) -> LightField:
        """The light field of a scene without lights, and of what stands outside."""
        shapes = self.inventory.shapes(scene, outside)
        return LightField(
            fluence=np.zeros((shapes.cells, 3)),
            body=np.zeros((self.voxels.count if self.voxels is not None else 1, 3)),
            irradiance=np.zeros((shapes.object_triangles, 3)),
        )

    def shares(self, scene: Any, outside: Outside | None = None) -> dict[str, int]:
        """Particles of each light: all strips together get `particles`, the room as many, a flashlight alone fewer."""
        names = light_names(scene, outside)
        strips = sum(name not in {FLASHLIGHT, ENVIRONMENT} for name in names)
        each = max(1, self.particles // max(1, strips))
        alone = self.inventory.shapes(scene, outside).object is None
        part = FLASHLIGHT_PART if alone else 1
        outer = {FLASHLIGHT: max(1, self.particles // part), ENVIRONMENT: self.particles}
        return {name: outer.get(name, each) for name in names}

    def light_fields(
        self, scene: Any, particles: Mapping[str, int], *, seed: int, outside: Outside | None = None
    ) -> dict[str, LightField]:
        """Light that emitters bring to every cell and to the object, by name.

        Args:
            scene: The loaded scene.
            particles: Number of particles of each light, all or some of `light_names(scene, outside)`.
            seed: Seed of the render; every light has a stream of its own.
            outside: What stands before the block in a scene of its own.
        """
        shapes = self.inventory.shapes(scene, outside)
        scatters = self.voxels is not None or (shapes.infill is not None and self.media.infill.sigma_s > 0)
        dark, lit = self.darkness(scene, outside), {name: particles[name] for name in particles if name not in self.off}
        if not lit or (shapes.object is None and not scatters):
            return dict.fromkeys(particles, dark)
        volumes = self.inventory.volumes_mm3(scene)
        tracks = {name: self._tracks(scene, shapes, name, count, seed, outside) for name, count in lit.items()}
        scales = {name: 1 / (FIXED_POINT * count) for name, count in lit.items()}
        landed = [tracks[name].landed.reshape(-1, 3) * scales[name] for name in tracks]
        # One product for all lights: reading the kernel costs more than using it.
        irradiance = self.inventory.irradiance(scene, shapes, np.concatenate(landed, 1))
        return dict.fromkeys(particles, dark) | {
            name: LightField(
                fluence=np.asarray(tracks[name].cells.reshape(-1, 3) * scales[name] / volumes, np.float64),
                body=np.asarray(tracks[name].body.reshape(-1, 3) * scales[name], np.float64),
                irradiance=irradiance[:, 3 * number : 3 * number + 3],
            )
            for number, name in enumerate(tracks)
        }

    def held_mm3(self, scene: Any) -> FloatArray:
        """Volume of the body in each voxel, shape (voxels, 1), 0 where it is next to nothing; 1 where it is clear."""
        if self.voxels is None:
            return np.ones((1, 1))
        return self.voxels.body_part(scene, self.inventory.shapes(scene)).held_mm3[:, None]

    def _tracks(
        self, scene: Any, shapes: Shapes, name: str, particles: int, seed: int, outside: Outside | None
    ) -> Tracks:
        """What the particles of one light leave behind."""
        stream, emitter = self.stream(scene, name, seed, outside), emitter_of(scene, name, outside)
        return sum_tracks(
            [
                self.light_pass(scene, shapes, starts, stream=stream, is_room=name == ENVIRONMENT)
                for starts in emitter_chunks(emitter, particles, seed=stream, inside=name in self.inside)
            ]
        )

    def light_pass(
        self, scene: Any, shapes: Shapes, starts: LightStarts, *, stream: int, is_room: bool = False,
        record: LightRecord | None = None,
    ) -> Tracks:  # fmt: skip
        """What particles leave behind.

        Args:
            scene: The loaded scene.
            shapes: Its shapes by their role.
            starts: Where the particles start.
            stream: Random stream.
            is_room: Whether light comes from all around.
            record: Takes down what leaves, or None.
        """
        media = self.followed_media if self.followed else self.media
        tracks: Tracks = deposit_tracks(
            scene, starts, shapes, media, self.voxels, seed=stream, is_room=is_room,
            max_depth=self.light_depth(media), balance=False, record=record,
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
        starts = EmitterStarts.of(
            emitter_of(scene, name), first=0, particles=particles, seed=seed, inside=name in self.inside
        )
        tracks = deposit_tracks(
            scene, starts, self.inventory.shapes(scene), self.media, self.voxels, seed=seed,
            is_room=name == ENVIRONMENT, max_depth=self.light_depth(self.media), balance=True, record=None,
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
        shapes = self.inventory.shapes(scene)
        starts = CameraStarts.of(
            scene.sensors()[0], samples=samples, window=window, pattern=pattern, part=range(samples)
        )
        seen = self.camera_pass(scene, shapes, field, starts, self.finish, stream=SEEDS_PER_RENDER * seed)
        return mi.TensorXf(dr.ravel(seen / samples), shape=(window.rows, window.columns, 3))

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

    def _cached(self, scene: Any, shapes: Shapes, field: LightField) -> CachedLight:
        centres, slopes = np.zeros((shapes.cells, 3)), np.zeros((shapes.cells, 3, 3))
        grid = self.inventory.grid(scene)
        if grid is not None and np.prod(self.counts) == shapes.cells:
            centres = grid.centres_mm
            slopes = cell_slopes(field.fluence, centres, self.counts)
        return CachedLight(
            cells=Piecewise(values=_flat(field.fluence), slopes=_flat(slopes), centres=_flat(centres)),
            body=_body_field(self.voxels, self.voxels.body_part(scene, shapes), field) if self.voxels else None,
            irradiance=_flat(field.irradiance),
        )

    def to_string(self) -> str:
        """One line for logs."""
        return f"FluenceIntegrator[particles={self.particles}]"


def _flat(values: FloatArray) -> Any:
    return mi.Float(values.astype(np.float32).ravel())


def _body_field(voxels: Voxels, part: BodyPart, field: LightField) -> VoxelField:
    held = part.held_mm3[:, None]
    fluence = np.divide(field.body, held, out=np.zeros_like(field.body), where=held > 0)
    slopes, inner = np.zeros((len(fluence), 3, 3)), voxels.inner
    slopes[inner] = cell_slopes(fluence[inner], part.centres_mm[inner], voxels.inner_counts)
    values = Piecewise(values=_flat(fluence), slopes=_flat(slopes), centres=_flat(part.centres_mm))
    return VoxelField(voxels=voxels, field=values)


mi.register_integrator("fluence", FluenceIntegrator)
