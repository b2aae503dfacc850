"""The light of a block: one object owns its scene and its media, and both passes are asked of it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from magicsim.arrays import Array, Numbers
from magicsim.camera.camera import Window
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import dr, floats, in_rows, mi
from magicsim.light.transport.cached_light import (
    BodyPart,
    CachedLight,
    Elements,
    Piecewise,
    VoxelField,
    body_elements,
    body_voxels,
    cell_elements,
)
from magicsim.light.transport.camera_pass import gather_radiance
from magicsim.light.transport.coat_light import CoatSolver
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.light_pass import Tracks, deposit_tracks, sum_tracks
from magicsim.light.transport.light_starts import ROOM_PART, ROUND_OBJECT, LightStarts, Sent, chunks, steps_of
from magicsim.light.transport.path_record import PathRecord
from magicsim.light.transport.path_starts import CameraStarts, ObjectStarts, PathStarts, object_rays
from magicsim.light.transport.recorded_light import LightRecord
from magicsim.light.transport.streams import COAT, ON_OBJECT, ROOM_ON_OBJECT, SEEDS_PER_RENDER
from magicsim.light.world.coated_face import CoatLight
from magicsim.light.world.inventory import Inventory
from magicsim.light.world.lamp_shapes import brightest_weight
from magicsim.light.world.loaded_scene import Outside, World
from magicsim.light.world.medium import Constants, Media
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT
from magicsim.light.world.scene_dict import WorldContent, lights_inside, lights_off
from magicsim.light.world.shapes import Shapes, in_body, mesh_of
from magicsim.scenes.rig import INSET_MM, Rig

LIGHT_DEPTH = 2000
"""Longest light path [interactions], and as many more as light needs to diffuse through the block. Roulette ends those
of the default sensor before 400; so short, they leave the white furnace of an infill of index 1 0.3 % too dark."""
DIFFUSION = 3.0
"""Collisions to diffuse across a block, in units of its scattering times its reduced scattering depth."""
CAMERA_DEPTH = 200
"""Longest camera path [interactions], below `path_record.STEPS`; roulette ends those of the default sensor before."""
FLASHLIGHT_PART = 4
"""In images without an anchor a flashlight on no object gets the strips' particles divided by this: their error
stays the same."""
STEPS = 8
"""Points of a scattering body on a camera ray to an opaque coat."""
RAYS_PER_PARTICLE = 0.5
"""Rays from the object for each particle of the light pass."""


class LitWorld(World):
    """A scene and the light in it: cached-fluence rendering of a scattering grid in a clear or scattering body.

    Unbiased for isotropic scattering in the limit of small cells and many particles.
    """

    def __init__(
        self, elastomer: Elastomer, rig: Rig, content: WorldContent, *, forward_collisions: int,
        own_mesh: SurfaceMesh | None = None, beside: tuple[int, int] = (0, 0),
    ) -> None:  # fmt: skip
        """Loads the scene at rest.

        First collisions of a camera path are followed by the true phase function. Few rays go out from triangles of the
        object from the first of `beside` to the second, which are at the edge of the picture at most.
        """
        super().__init__(elastomer, rig, content, for_paths=False)
        self.inventory = Inventory(self.scene, self.block, elastomer, rig, own_mesh)
        self.media = Media.of(elastomer.design)
        """Scattering as it is given; where no collision is followed, the passes take its reduced form."""
        self.voxels = body_voxels(elastomer, INSET_MM) if self.media.body.sigma_s > 0 else None
        """Voxels of the body, or None where it does not scatter."""
        self.counts = elastomer.grid.counts if elastomer.grid is not None else (1, 1, 1)
        """Cells along x, y and z."""
        self._followed = forward_collisions if self.media.infill.anisotropy else 0
        self._inside, self._off = frozenset(lights_inside(rig)), frozenset(lights_off(rig))
        self._beside = beside

    @property
    def voxel_counts(self) -> tuple[int, int, int] | None:
        """Voxels of the body along x, y and z, or None where it does not scatter."""
        return self.voxels.counts if self.voxels is not None else None

    def image(
        self, names: Sequence[str], *, samples: int, particles: int, seed: int, pattern: int = 0,
        window: Window | None = None,
    ) -> Any:  # fmt: skip
        """Radiance of a window of the film by some lights, a tensor of shape (rows, columns, 3)."""
        shares = self.shares(particles)
        fields = self.light_fields({name: shares[name] for name in names}, seed=seed)
        field = self.with_lit_object(total([self.darkness(), *fields.values()]), particles=particles, seed=seed)
        return self.gather(field, samples=samples, seed=seed, pattern=pattern, window=window)

    def darkness(self, outside: Outside | None = None) -> LightField:
        """The light field of a scene without lights, and of what stands outside."""
        shapes = self.inventory.shapes(outside)
        return LightField(
            fluence=np.zeros((shapes.cells, 3)),
            body=np.zeros((self.voxels.count if self.voxels is not None else 1, 3)),
            irradiance=np.zeros((shapes.object_triangles, 3)),
        )

    def shares(self, particles: int) -> dict[str, int]:
        """Particles of each light: all strips together get so many, the room and a flashlight alone fewer."""
        names = self.lights
        strips = sum(name not in {FLASHLIGHT, ENVIRONMENT} for name in names)
        part = FLASHLIGHT_PART if self.inventory.shapes().object is None else 1
        outer = {FLASHLIGHT: max(1, particles // part), ENVIRONMENT: max(1, particles // ROOM_PART)}
        return {name: outer.get(name, max(1, particles // max(1, strips))) for name in names}

    def light_fields(
        self, particles: Mapping[str, int], *, seed: int, outside: Outside | None = None,
        record: LightRecord | None = None,
    ) -> dict[str, LightField]:  # fmt: skip
        """Light that emitters bring to every cell and to the object, by name."""
        shapes = self.inventory.shapes(outside)
        scatters = self.voxels is not None or (shapes.infill is not None and self.media.infill.sigma_s > 0)
        dark, lit = self.darkness(outside), {name: particles[name] for name in particles if name not in self._off}
        if not lit or self.is_integrated or (shapes.object is None and not scatters and record is None):
            return dict.fromkeys(particles, dark)
        sent = [
            each
            for place, (name, count) in enumerate(lit.items())
            for each in self.sent(name, count, seed=seed, place=place, outside=outside)
        ]
        tracks = sum_tracks(
            [
                self.light_pass(LightStarts.emitted(chunk), lights=len(lit), outside=outside, record=record)
                for chunk in chunks(sent)
            ]
        )
        steps = {each.place: each.steps for each in sent}
        counts = [steps[place] * count for place, count in enumerate(lit.values())]
        scales = 1 / np.array(counts, float)[:, None, None]
        # One product for all lights: reading the kernel costs more than using it.
        irradiance = self.inventory.irradiance(shapes, np.concatenate(list(tracks.landed * scales), 1))
        fluence, body = tracks.cells * scales / self.inventory.volumes_mm3(), tracks.body * scales
        return dict.fromkeys(particles, dark) | {
            name: LightField(
                fluence=fluence[place], body=body[place], irradiance=irradiance[:, 3 * place : 3 * place + 3]
            )
            for place, name in enumerate(lit)
        }

    def brought(self, tracks: Tracks, scale: float, outside: Outside | None = None) -> LightField:
        """The light field of what particles of one light left behind, each step of which counts as much as `scale`."""
        return self.deposited(tracks.cells[0] * scale, tracks.body[0] * scale, tracks.landed[0] * scale, outside)

    def deposited(self, cells: Array, body: Array, landed: Array, outside: Outside | None = None) -> LightField:
        """The light field of what particles left behind: flux x path length in cells and voxels, flux on triangles."""
        irradiance = self.inventory.irradiance(self.inventory.shapes(outside), landed)
        return LightField(fluence=cells / self.inventory.volumes_mm3(), body=body, irradiance=irradiance)

    def sent(self, name: str, count: int, *, seed: int, place: int = 0, outside: Outside | None = None) -> list[Sent]:
        """What one light sends out: the room one beam, and a second one with fewer particles around an object."""
        stream = SEEDS_PER_RENDER * seed + 1 + self.inventory.lights(outside).index(name)
        emitter = self.inventory.emitter(name, outside)
        first = Sent(emitter, 0, count, stream, name in self._inside, place)
        if name != ENVIRONMENT:
            return [first._replace(steps=steps_of(brightest_weight(emitter)))]
        fewer = max(1, round(ROUND_OBJECT * count))
        around = first._replace(particles=fewer, seed=SEEDS_PER_RENDER * seed + ROOM_ON_OBJECT, weight=count / fewer)
        parts = zip((first, around), self.inventory.beams(outside), strict=False)
        return [each._replace(beam=beam) for each, beam in parts]

    def with_lit_object(
        self, field: LightField, *, particles: int, seed: int, outside: Outside | None = None, room: Any = None
    ) -> LightField:
        """The field with the irradiance of the object gathered by rays from its surface, see `object_light`."""
        shapes = self.inventory.shapes(outside)
        if shapes.object is None or self.elastomer.design.is_opaque:
            return field
        stream = SEEDS_PER_RENDER * seed + ON_OBJECT
        count = max(1, round(RAYS_PER_PARTICLE * particles))
        sent = object_rays(mesh_of(shapes.object), count, seed=stream, beside=self._beside)
        inside = mi.Bool(False) if shapes.outside is not None else in_body(self.scene, shapes, sent.rays.o)
        starts = ObjectStarts.of(dr.arange(mi.UInt32, len(sent.triangle)), sent.rays, mi.Float(1), inside)
        dr.eval(starts)
        met = in_rows(self.camera_pass(field, starts, stream=stream, outside=outside, room=room))
        count = shapes.object_triangles
        weights = [np.pi * sent.area_mm2 * channel for channel in met.T]
        flux = np.stack([np.bincount(sent.triangle, weight, count) for weight in weights], 1).astype(np.float64)
        areas = np.bincount(sent.triangle, sent.area_mm2, count).astype(np.float64)
        gathered = self.inventory.gathered_irradiance(shapes, flux, areas, field.irradiance)
        return replace(field, irradiance=gathered)

    def held_mm3(self) -> Array:
        """Volume of the body in each voxel, shape (voxels, 1), 0 where it is next to nothing; 1 where it is clear."""
        part = self.body_part()
        return part.held_mm3[:, None] if part is not None else np.ones((1, 1))

    def body_part(self) -> BodyPart | None:
        """What the voxels hold of the body, or None where it is clear."""
        return self.voxels.body_part(self.scene, self.inventory.shapes()) if self.voxels is not None else None

    def growth(self, held_mm3: Array) -> Array:
        """What each voxel holds of the body over what it held, shape (voxels, 1); 0 where it held nothing."""
        return np.divide(self.held_mm3(), held_mm3, out=np.zeros_like(held_mm3), where=held_mm3 > 0)

    def light_pass(
        self, starts: LightStarts, *, lights: int = 1, outside: Outside | None = None,
        record: LightRecord | None = None, media: Media | None = None, balance: bool = False,
    ) -> Tracks:  # fmt: skip
        """What particles leave behind; `balance` keeps account of where their light goes."""
        media = media or (self.media if self._followed else self.media.reduced)
        depths = [medium.sigma_s * medium.reduced.sigma_s * media.top_mm**2 for medium in (media.body, media.infill)]
        scene, shapes = self._traced(outside)
        tracks: Tracks = deposit_tracks(
            scene, starts, shapes, media, self.voxels, lights=lights,
            max_depth=int(LIGHT_DEPTH + DIFFUSION * max(depths)), balance=balance, record=record,
        )  # fmt: skip
        return tracks

    def balance(self, name: str, *, particles: int, seed: int) -> dict[str, float]:
        """Where the flux of one light goes, summed over channels: `emitted`, `absorbed`, `escaped`, and `ended`.

        The last is what ended paths still carried less what roulette gave to others, zero in the mean.
        """
        sent, media = [each._replace(seed=seed) for each in self.sent(name, particles, seed=0)], self.media.reduced
        tracks = self.light_pass(LightStarts.emitted(sent), media=media, balance=True)
        assert tracks.balance is not None
        account = {kind: float(flux.sum()) for kind, flux in tracks.balance.items()}
        scattered = media.infill.sigma_a * tracks.cells.sum() + media.body.sigma_a * tracks.body.sum()
        absorbed = float(scattered) / sent[0].steps + account["clear_body"] + account["surfaces"]
        return {kind: account[kind] for kind in ("emitted", "escaped", "ended")} | {"absorbed": absorbed}

    def _traced(self, outside: Outside | None, room: Any = None) -> tuple[Any, Shapes]:
        """Scene that a pass follows its rays in, and its shapes by their role."""
        if outside is None or outside.joined is None:
            return self.scene, self.inventory.shapes(outside, room)
        return outside.joined.scene, outside.joined.inventory.shapes(room=room)

    def gather(
        self, field: LightField, *, samples: int, seed: int, pattern: int = 0, window: Window | None = None
    ) -> Any:
        """Radiance of a window of the film from cached light, a tensor of shape (rows, columns, 3)."""
        columns, rows = (int(size) for size in self.scene.sensors()[0].film().size())
        window = window or Window.whole(columns, rows)
        pixels = window.numbers(columns, rows)
        seen = self.gather_pixels(field, pixels, samples=samples, seed=seed, pattern=pattern)
        return mi.TensorXf(dr.ravel(seen), shape=(window.rows, window.columns, 3))

    def gather_pixels(
        self, field: LightField, pixels: Numbers, *, samples: int, seed: int, pattern: int = 0, room: Any = None
    ) -> Any:
        """Radiance of some pixels of the film from cached light, mi.Color3f."""
        starts = CameraStarts.of(
            self.scene.sensors()[0], samples=samples, pixels=pixels, pattern=pattern, part=range(samples)
        )
        known, coat = self.on_coat(field, seed=seed)
        return self.camera_pass(known, starts, stream=SEEDS_PER_RENDER * seed, room=room, coat=coat) / samples

    @property
    def is_integrated(self) -> bool:
        """Whether all light is found without particles: under an opaque coat, where no grid is in its way."""
        return self.elastomer.design.is_opaque and self.elastomer.grid is None

    def on_coat(self, field: LightField, *, seed: int) -> tuple[LightField, CoatLight | None]:
        """What an opaque coat sends out, and the field with the light that it depends on; None where there is none."""
        face = self.inventory.coated_face()
        if face is None:
            return field, None
        part = self.body_part()
        stream = SEEDS_PER_RENDER * seed + COAT

        def lit(glow: Array | None) -> LightField:
            if glow is None or part is None:
                return field
            return replace(field, body=glow * part.held_mm3[:, None])

        def trace(starts: ObjectStarts, coat: CoatLight, glow: Array | None) -> Any:
            return self.camera_pass(lit(glow), starts, stream=stream, coat=coat)

        coating, camera = self.inventory.shapes().coating, self.rig.camera
        box = coating.box(Constants.of(self.media.reduced))
        pinhole = self.elastomer.design.height_mm + self.rig.lens.thickness_mm + camera.distance_mm
        solver = CoatSolver(
            scene=self.scene, coating=coating, face=face, box=box, pinhole_mm=np.array([0.0, 0.0, pinhole]),
            trace=trace, voxels_mm=part.centres_mm if part is not None and self.is_integrated else None,
        )  # fmt: skip
        light, glow = solver.solved()
        return lit(glow), light

    def camera_pass(
        self, field: LightField, starts: PathStarts, *, stream: int, outside: Outside | None = None, room: Any = None,
        record: PathRecord | None = None, coat: CoatLight | None = None,
    ) -> Any:  # fmt: skip
        """Radiance summed over each lane's paths, mi.Color3f."""
        scene, shapes = self._traced(outside, room)
        if coat is not None:
            shapes = replace(shapes, coating=replace(shapes.coating, light=coat, asks_sides=True))
        steps = STEPS if coat is not None and isinstance(starts, CameraStarts) else 1
        return gather_radiance(
            scene, shapes, self.media.reduced,
            self._cached(field, is_change=room is not None, steps=steps), self.content.object_finish, starts,
            seed=stream, max_depth=CAMERA_DEPTH, forward=self.media.infill if self._followed else None,
            followed=self._followed, record=record,
        )  # fmt: skip

    def elements(self, field: LightField) -> Elements:
        """Light in the cells and then in the voxels of a body that scatters, as camera paths look it up."""
        return Elements(*(np.concatenate(each) for each in zip(*self._elements(field), strict=True)))

    def _elements(self, field: LightField) -> list[Elements]:
        grid, part = self.inventory.grid(), self.body_part()
        cells = cell_elements(field.fluence, grid.centres_mm if grid is not None else None, self.counts)
        return [cells] if self.voxels is None or part is None else [cells, body_elements(field.body, part, self.voxels)]

    def _cached(self, field: LightField, *, is_change: bool, steps: int) -> CachedLight:
        cells, *body = (Piecewise.of(each, is_change=is_change) for each in self._elements(field))
        voxels = self.voxels
        inside = VoxelField(voxels=voxels, field=body[0], steps=steps) if voxels is not None else None
        return CachedLight(cells=cells, body=inside, irradiance=floats(field.irradiance))
