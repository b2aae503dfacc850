"""Coat and markers of the contact face, as both passes meet them: paint that is opaque, a film of metal elsewhere.

Paint is a picture over the undeformed face. Each of its triangles has an affine map from places in the scene to texels
of that picture, computed anew for each state of the mesh, so that colours move with the skin.

Light that a camera path meets on paint comes from the lights in ways that share no path. Lights within the body, in
straight line or by one reflection at the flat lens face, and lamps behind that face are asked for (`straight_light`).
All others are met by going on in a random direction; such a path then does not count a light that it meets straight
away, after that one reflection, or after it has left through the lens face.
"""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from magicsim.geometry.coat import HalfMirror, OpaqueCoat
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.face_paint import face_paint
from magicsim.light.backend import OfMesh, dr, floats, mi
from magicsim.light.world.coated_face import CoatedFace, CoatLight, affine_maps
from magicsim.light.world.medium import Constants, Segment, leave
from magicsim.light.world.scene_dict import lights_inside
from magicsim.light.world.shapes import mesh_of
from magicsim.light.world.straight_light import OFF_MM, Box, Lamps, Strips, straight_lights
from magicsim.scenes.rig import Rig

ASKED, CROSSED = 1, 64
"""What was asked for the lights: straight away before, and before a way out through the lens face; the former and the
bits below after a reflection."""
BITS = (2, 4, 8)
"""After a reflection at a side along x, one along y, and the lens face."""
WIDE = 0.15
"""Least roughness of facets whose share of lights is asked for; sharper ones find them better by going on."""
NOT_ON_FACE = -1e9
"""Texel of triangles that do not belong to the contact face."""
LEVEL, UPRIGHT = 0.999, 0.99
"""Least part of the normals of lens face and sides along their axis."""
BULGE_MM = 0.2
"""How far a side may be off its place [mm]."""
CLEAR = (0.0, 0.0, 0.0, 0.0)


@dataclass(slots=True, kw_only=True)
class Met:
    """What rays meet on the body; every field is a Dr.Jit array over rays."""

    painted: Any
    color: Any
    """Diffuse reflectance of paint, mi.Color3f."""
    reflectance: Any
    """Reflectance of the interface, its film included, as a share of what is kept."""
    kept: Any
    """Share that a film does not absorb, 1 elsewhere."""


@dataclass(slots=True, kw_only=True)
class Coating:
    """Arrays on the renderer's side."""

    maps: Any
    """Affine map of each triangle of the body to columns and rows of the texels, eight floats."""
    texels: Any
    """Linear RGB and opacity, four floats each."""
    columns: int
    rows: int
    specular: Any
    """Share of light that paint mirrors."""
    roughness: Any
    plate_mm: Any
    """Height of the flat lens face [mm]."""
    is_wide: bool
    """Whether lights are asked for what the facets mirror of them too."""
    lights: list[Strips | Lamps]
    """Those that are asked for."""
    half_mm: tuple[Any, Any]
    """Half of the footprint along x and y [mm]."""
    asks_sides: bool = False
    """Whether lights are asked for by way of the body's sides too."""
    light: CoatLight | None = None
    """What the coat sends out, where that is known; camera paths then end there."""
    film: tuple[Any, Any] | None
    """Reflectance and transmittance of the film; None without."""

    def meet(self, si: Any, segment: Segment, reflectance: Any, sample: Any, active: Any) -> Met:
        """What a hit on the body meets; the sample decides where paint is partly opaque."""
        on_body = active & segment.on_body
        across, along = (dr.gather(mi.Vector4f, self.maps, 2 * si.prim_index + axis, on_body) for axis in (0, 1))
        column, row = (dr.fma(m.x, si.p.x, dr.fma(m.y, si.p.y, dr.fma(m.z, si.p.z, m.w))) for m in (across, along))
        on_face = on_body & (column > NOT_ON_FACE / 2)
        texel = self._texel(column, row, on_face)
        painted = on_face & (sample < texel.w)
        color = mi.Color3f(texel.x, texel.y, texel.z)
        reflectance, kept = self._through_film(reflectance, segment, on_face & ~painted)
        return Met(painted=painted, color=color, reflectance=reflectance, kept=kept)

    def _texel(self, column: Any, row: Any, active: Any) -> Any:
        """Linear between the centres of texels, those at the border going on."""
        column, row = (dr.clip(at - 0.5, 0, size - 1) for at, size in ((column, self.columns), (row, self.rows)))
        left, low = mi.UInt32(column), mi.UInt32(row)
        right, high = dr.minimum(left + 1, self.columns - 1), dr.minimum(low + 1, self.rows - 1)
        u, v = column - mi.Float(left), row - mi.Float(low)

        def at(x: Any, y: Any) -> Any:
            return dr.gather(mi.Vector4f, self.texels, y * self.columns + x, active)

        below, above = dr.lerp(at(left, low), at(right, low), u), dr.lerp(at(left, high), at(right, high), u)
        return dr.lerp(below, above, v)

    def _through_film(self, reflectance: Any, segment: Segment, clear: Any) -> tuple[Any, Any]:
        """Share of what goes on that is reflected, and the share that goes on, to and fro before a film."""
        if self.film is None:
            return reflectance, mi.Float(1)
        own, passed = self.film
        series = dr.rcp(1 - own * reflectance)
        inner = own + dr.square(passed) * reflectance * series
        outer = reflectance + dr.square(1 - reflectance) * own * series
        back = dr.select(segment.entering, outer, inner)
        kept = back + passed * (1 - reflectance) * series
        return dr.select(clear, back / dr.maximum(kept, 1e-9), reflectance), dr.select(clear, kept, 1)

    def bounce(self, si: Any, met: Met, choice: Any, sample: Any) -> tuple[Any, Any, Any]:
        """Local direction that light takes from paint, its weight, and whether the ground, not the mirror, sent it."""
        side = dr.sign(mi.Frame3f.cos_theta(si.wi))
        arriving = mi.Vector3f(si.wi.x, si.wi.y, dr.abs(si.wi.z))
        facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.roughness, sample_visible=True)
        normal, _ = facets.sample(arriving, sample)
        mirrored = mi.reflect(arriving, normal)
        on_ground = choice >= self.specular
        away = dr.select(on_ground, mi.warp.square_to_cosine_hemisphere(sample), mirrored)
        lit = dr.select(mirrored.z > 0, facets.smith_g1(mirrored, normal), 0)
        weight = dr.select(on_ground, met.color, mi.Color3f(lit))
        return mi.Vector3f(away.x, away.y, side * away.z), weight, on_ground

    def lit(self, scene: Any, si: Any, met: Met, constants: Constants, sample: Any, active: Any) -> Any:
        """Radiance that paint sends on of lights that are asked for, by a random point of each, mi.Color3f."""
        found, box = mi.Color3f(0), self.box(constants)
        inward = dr.mulsign(mi.Vector3f(si.n), mi.Frame3f.cos_theta(si.wi))
        place, towards = leave(si, inward).o, si.to_world(si.wi)
        for light in self.lights:
            for row in light.straight:
                arriving = light.arriving(mi.UInt32(row), place, sample, box)
                ground, mirrored = self.shares(arriving.direction, towards, inward)
                clear = arriving.unblocked(scene, active)
                found += dr.select(clear, arriving.light * (ground * met.color + mirrored), 0)
        return found

    def box(self, constants: Constants) -> Box:
        """The body as lights shine through it."""
        return Box(height_mm=self.plate_mm, half_mm=self.half_mm, constants=constants)

    def shares(self, arriving: Any, leaving: Any, normal: Any) -> tuple[Any, Any]:
        """What ground of reflectance 1 and facets send on for each unit of arriving radiance and solid angle."""
        cosine, outward = dr.dot(normal, arriving), dr.dot(normal, leaving)
        lit = (cosine > 0) & (outward > 0)
        ground = dr.select(lit, cosine * ((1 - self.specular) * dr.inv_pi), 0)
        if not self.is_wide:
            return ground, mi.Float(0)
        frame = mi.Frame3f(mi.Normal3f(normal))
        wi, wo = frame.to_local(leaving), frame.to_local(arriving)
        half = dr.normalize(wi + wo)
        facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.roughness, sample_visible=True)
        shadowed = facets.smith_g1(wi, half) * facets.smith_g1(wo, half)
        return ground, dr.select(lit, self.specular * facets.eval(half) * shadowed / (4 * outward), 0)

    def after(self, si: Any, asked: Any, reflected: Any) -> Any:
        """What was asked for the lights after a hit on the body's surface from within, see `ASKED`."""
        on_lens = (si.p.z > self.plate_mm - OFF_MM) & (si.n.z > LEVEL)
        on = [mi.Bool(False), mi.Bool(False), on_lens]
        if self.asks_sides:
            for axis in range(2):
                on[axis] = ~on_lens & (dr.abs(si.n[axis]) > UPRIGHT)
                on[axis] &= dr.abs(si.p[axis]) > self.half_mm[axis] - BULGE_MM
        following = mi.UInt32(0)
        for bit, met in zip(BITS, on, strict=True):
            following = dr.select(met & ((asked & bit) == 0) & reflected, asked | bit, following)
        crossed = on_lens & ((asked & BITS[-1]) == 0) & ~reflected
        following = dr.select(crossed, mi.UInt32(CROSSED), following)
        return dr.select(asked & ASKED == ASKED, following, 0)


@dataclass(slots=True, kw_only=True)
class SentOn:
    """How paths go on from paint; every field is a Dr.Jit array over rays."""

    local: Any
    """Direction in the local frame."""
    share: Any
    """Factor of the weight, 1 where nothing is painted."""
    lit: Any
    """Radiance of lights that were asked for, mi.Color3f."""
    asks: Any
    """Whether they were."""


def send_on(
    coating: Coating | None, scene: Any, si: Any, segment: Segment, face: Met, constants: Constants,
    samples: tuple[Any, Any], sampler: Any, straight: Any, active: Any,
) -> SentOn:  # fmt: skip
    """Camera paths that go on from paint; a bare face, for which `coating` is None, takes no random number."""
    if coating is None:
        return SentOn(local=mi.Vector3f(0, 0, 1), share=mi.Float(1), lit=mi.Color3f(0), asks=mi.Bool(False))
    painted = active & face.painted
    within = painted & ~segment.entering
    if coating.light is not None:
        known = coating.light.sent(si, face.color, straight, within)
        # Facets that mirror sharply are followed, all others are known.
        local, share, _ = coating.bounce(si, face, mi.Float(-1), samples[1])
        share = dr.select(within, share * (0 if coating.is_wide else coating.specular), 0)
        return SentOn(local=local, share=dr.select(painted, share, 1), lit=known, asks=mi.Bool(False))
    place = mi.Point2f(sampler.next_float32(active), sampler.next_float32(active))
    lit = coating.lit(scene, si, face, constants, place, within)
    local, share, on_ground = coating.bounce(si, face, *samples)
    return SentOn(local=local, share=dr.select(painted, share, 1), lit=lit, asks=within & (on_ground | coating.is_wide))


def bounced(coating: Coating | None, si: Any, face: Met, choice: Any, sample: Any) -> tuple[Any, Any]:
    """Local direction in which particles leave paint, and the factor of their weight, 1 elsewhere."""
    if coating is None:
        return mi.Vector3f(0, 0, 1), mi.Float(1)
    local, share, _ = coating.bounce(si, face, choice, sample)
    return local, dr.select(face.painted, share, 1)


def after_surface(coating: Coating | None, si: Any, asked: Any, leaving: Any, reflected: Any) -> Any:
    """What was asked for the lights after the body's surface: only its first meetings with each mirror are known."""
    if coating is None:
        return mi.UInt32(0)
    return dr.select(leaving, coating.after(si, asked, reflected), 0)


def meet_face(coating: Coating | None, si: Any, segment: Segment, reflectance: Any, sampler: Any, active: Any) -> Met:
    """What hits on the body meet; a bare face takes no random number."""
    if coating is None:
        return Met(painted=mi.Bool(False), color=mi.Color3f(0), reflectance=reflectance, kept=mi.Float(1))
    return coating.meet(si, segment, reflectance, sampler.next_float32(active), active)


class FaceCoating:
    """Coat and markers of a block, which follow its mesh."""

    def __init__(self, elastomer: Elastomer, rig: Rig) -> None:
        design, paint = elastomer.design, face_paint(elastomer.design)
        coat = design.coat
        texels = paint.texels if paint is not None else np.array(CLEAR).reshape(1, 1, 4)
        pixel, origin = (paint.pixel_mm, paint.origin_mm) if paint is not None else (1.0, (0.0, 0.0))
        specular, roughness = (coat.specular, coat.roughness) if isinstance(coat, OpaqueCoat) else (0.0, 1.0)
        half = [dr.opaque(mi.Float, size / 2) for size in design.footprint_mm]
        film = None
        if isinstance(coat, HalfMirror):
            film = dr.opaque(mi.Float, coat.reflectance), dr.opaque(mi.Float, coat.transmittance)
        self._plate_mm, self._inside = design.height_mm + rig.lens.thickness_mm, tuple(lights_inside(rig))
        self._anywhere = Coating(
            maps=None, texels=floats(texels), columns=texels.shape[1],
            rows=texels.shape[0], specular=dr.opaque(mi.Float, specular), roughness=dr.opaque(mi.Float, roughness),
            film=film, plate_mm=dr.opaque(mi.Float, self._plate_mm), is_wide=specular > 0 and roughness >= WIDE,
            lights=[], half_mm=(half[0], half[1]),
        )  # fmt: skip
        self.is_opaque = isinstance(coat, OpaqueCoat)
        """Whether all of the face is painted."""
        faces, vertices = elastomer.body.faces, elastomer.body.vertices
        self._is_face = elastomer.is_face[faces].all(1)
        self._faces = faces
        self._rest_mm = vertices[:, :2]
        self._places = (vertices[:, :2] - origin) / pixel
        self._coating = OfMesh()

    @classmethod
    def of(cls, elastomer: Elastomer, rig: Rig) -> Self | None:
        """Coating of a block on a rig, or None where its face is bare."""
        return cls(elastomer, rig) if elastomer.design.face_is_special else None

    def face(self, body: Any) -> CoatedFace:
        """The face of the body's mesh as it is now."""
        return CoatedFace(
            places_mm=mesh_of(body).vertices, rest_mm=self._rest_mm, facets=self._faces[self._is_face].astype(np.int64),
            numbers=np.flatnonzero(self._is_face), triangles=len(self._faces),
        )  # fmt: skip

    def on(self, body: Any, scene: Any) -> Coating:
        """The coating of the body's mesh and the lights of the scene as they are now."""
        now: Coating = self._coating.of(body, self._mapped)
        return replace(now, lights=straight_lights(scene, self._inside, self._plate_mm))

    def _mapped(self, body: Any) -> Coating:
        vertices = mesh_of(body).vertices
        maps = np.zeros((len(self._faces), 2, 4))
        maps[:, :, 3] = NOT_ON_FACE
        faces = self._faces[self._is_face]
        maps[self._is_face] = affine_maps(vertices[faces], self._places[faces])
        return replace(self._anywhere, maps=floats(maps))
