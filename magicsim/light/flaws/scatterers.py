"""Bubbles and flakes as light meets them inside a cell: one event each, found among those of the cell that a ray is in.

A bubble is a sphere of air by geometric optics. What does not reflect at its surface runs along chords of one length
inside and leaves at one of their ends, so that place and direction follow in closed form from the number of chords. A
flake is a round diffuse platelet that both sides send light back from.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.printed_cells import PlacedInclusions
from magicsim.light.backend import aligned, dr, floats, mi

OFF_MM = 2e-6
"""How far off a flake light goes on from it [mm]."""
MOST_CHORDS = 64


@dataclass(slots=True, kw_only=True)
class Scatterers:
    """Arrays on the renderer's side."""

    first: Any
    """Number of each cell's first one, and of all, mi.UInt32."""
    spheres: Any
    """Centre [mm] and radius [mm], four floats each."""
    normals: Any
    """Normals of flakes, four floats each; the last is 1 for a bubble."""
    eta: Any
    """Index of air over that of the infill."""
    reflectance: Any
    """Reflectance of flakes."""

    @classmethod
    def of(cls, placed: PlacedInclusions, cells: int, infill_ior: float, reflectance: float) -> Self:
        """From where they are."""
        first = np.searchsorted(placed.cell, np.arange(cells + 1))
        spheres = np.column_stack([placed.centres_mm, placed.radii_mm])
        normals = np.column_stack([placed.normals, placed.is_bubble])
        return cls(
            first=mi.UInt32(aligned(first, np.uint32)),
            spheres=floats(spheres),
            normals=floats(normals),
            eta=dr.opaque(mi.Float, 1 / infill_ior),
            reflectance=dr.opaque(mi.Float, reflectance),
        )


@dataclass(slots=True, kw_only=True)
class Bump:
    """What rays meet before the wall of their cell; every field is a Dr.Jit array over rays."""

    found: Any
    length: Any
    """Way to it, or to the end of the segment [mm]."""
    number: Any


@dataclass(slots=True, kw_only=True)
class Turned:
    """How rays go on from a bubble or a flake; every field is a Dr.Jit array over rays."""

    place: Any
    direction: Any
    share: Any
    """Factor of the weight."""


def bump_ahead(scatterers: Scatterers | None, ray: Any, si: Any, cell: Any, active: Any) -> Bump:
    """What rays in cells meet before their wall; nothing where a print is clean."""
    if scatterers is None:
        return Bump(found=mi.Bool(False), length=si.t, number=mi.UInt32(0))
    length, number = _nearest(scatterers, ray, si.t, cell, active)
    return Bump(found=active & (length < si.t), length=length, number=number)


@dr.syntax  # type: ignore[untyped-decorator]
def _nearest(scatterers: Scatterers, ray: Any, limit: Any, cell: Any, active: Any) -> Any:
    """Way to the nearest one before a limit, and its number."""
    each = dr.gather(mi.UInt32, scatterers.first, cell, active)
    end = dr.gather(mi.UInt32, scatterers.first, cell + 1, active)
    nearest, number = mi.Float(limit), mi.UInt32(0)
    going = active & (each < end)
    while going:
        sphere = dr.gather(mi.Vector4f, scatterers.spheres, each, going)
        normal = dr.gather(mi.Vector4f, scatterers.normals, each, going)
        away = mi.Point3f(sphere.x, sphere.y, sphere.z) - ray.o
        closest = dr.dot(away, ray.d)
        off = dr.squared_norm(away - closest * ray.d)
        half = dr.square(sphere.w) - off
        bubble = closest - dr.safe_sqrt(half)
        flat = mi.Vector3f(normal.x, normal.y, normal.z)
        steep = dr.dot(flat, ray.d)
        flake = dr.dot(flat, away) / dr.select(dr.abs(steep) > OFF_MM, steep, OFF_MM)
        on_flake = dr.squared_norm(flake * ray.d - away) <= dr.square(sphere.w)
        is_bubble = normal.w > 0
        way = dr.select(is_bubble, bubble, flake)
        # From a sphere's own surface outwards its centre lies behind.
        hit = dr.select(is_bubble, (half > 0) & (closest > 0), on_flake) & (way > 0) & (way < nearest)
        nearest = dr.select(going & hit, way, nearest)
        number = dr.select(going & hit, each, number)
        each += 1
        going &= each < end
    return nearest, number


def turned(scatterers: Scatterers | None, ray: Any, bump: Bump, sampler: Any) -> Turned:
    """How rays go on; a clean print takes no random number."""
    if scatterers is None:
        return Turned(place=ray.o, direction=ray.d, share=mi.Float(1))
    numbers = [sampler.next_float32() for _ in range(4)]
    sphere = dr.gather(mi.Vector4f, scatterers.spheres, bump.number, bump.found)
    normal = dr.gather(mi.Vector4f, scatterers.normals, bump.number, bump.found)
    centre, point = mi.Point3f(sphere.x, sphere.y, sphere.z), ray(bump.length)
    is_bubble = normal.w > 0
    place, direction = _through_bubble(scatterers, point, centre, sphere.w, ray.d, numbers[0], numbers[1])
    flat = mi.Vector3f(normal.x, normal.y, normal.z)
    facing = dr.mulsign(flat, -dr.dot(flat, ray.d))
    back = mi.Frame3f(facing).to_world(mi.warp.square_to_cosine_hemisphere(mi.Point2f(numbers[2], numbers[3])))
    return Turned(
        place=dr.select(is_bubble, place, point + OFF_MM * facing),
        direction=dr.select(is_bubble, direction, back),
        share=dr.select(is_bubble, 1, scatterers.reflectance),
    )


def _through_bubble(
    scatterers: Scatterers, point: Any, centre: Any, radius: Any, way: Any, u: Any, v: Any
) -> tuple[Any, Any]:
    """Where and in which direction light leaves a bubble; `u` decides whether it enters, `v` after how many chords."""
    normal = dr.normalize(point - centre)
    cosine = dr.clip(-dr.dot(normal, way), 0, 1)
    tangent = way + cosine * normal
    sine = dr.norm(tangent)
    tangent = dr.select(sine > OFF_MM, tangent / dr.maximum(sine, OFF_MM), mi.coordinate_system(normal)[0])
    reflectance, cosine_t = mi.fresnel(cosine, scatterers.eta)[:2]
    reflects = u < reflectance
    # A chord leaves with the share that entered: reflections within are geometric.
    held = dr.clip(reflectance, 1e-6, 1 - 1e-6)
    chords = 1 + dr.minimum(dr.floor(dr.log(1 - v) / dr.log(held)), MOST_CHORDS)
    turn = chords * 2 * dr.safe_asin(dr.clip(dr.abs(cosine_t), 0, 1))
    turn = dr.select(reflects, 0, turn)
    out = dr.cos(turn) * normal + dr.sin(turn) * tangent
    along = dr.cos(turn) * tangent - dr.sin(turn) * normal
    return centre + radius * out, dr.normalize(cosine * out + sine * along)


def scatterer_name(number: int) -> str:
    """Name of a bubble's or a flake's shape."""
    return f"inclusion{number}"


def scatterer_entries(placed: PlacedInclusions, infill_ior: float, reflectance: float, medium: Any) -> dict[str, Any]:
    """Bubbles and flakes as shapes for Mitsuba's own integrators: entries of a scene's dictionary, by name."""
    around = {} if medium is None else {"exterior": medium}
    air = {"type": "dielectric", "int_ior": 1.0, "ext_ior": infill_ior}
    ground = {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}}
    flake = {"type": "twosided", "bsdf": ground}
    entries: dict[str, Any] = {}
    for number, to_world in enumerate(transforms(placed)):
        kind = (
            {"type": "sphere", "bsdf": air, **around} if placed.is_bubble[number] else {"type": "disk", "bsdf": flake}
        )
        entries[scatterer_name(number)] = kind | {"to_world": mi.ScalarTransform4f(to_world)}
    return entries


def transforms(placed: PlacedInclusions) -> np.ndarray[Any, np.dtype[np.float64]]:
    """From a unit sphere, or a unit disk across z, to each one's place, shape (inclusions, 4, 4)."""
    axis = np.eye(3)[np.abs(placed.normals).argmin(1)]
    across = np.cross(placed.normals, axis)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turned = np.stack([across, np.cross(placed.normals, across), placed.normals], 2)
    turned[placed.is_bubble] = np.eye(3)
    found = np.zeros((len(turned), 4, 4))
    found[:, :3, :3] = turned * placed.radii_mm[:, None, None]
    found[:, :3, 3] = placed.centres_mm
    found[:, 3, 3] = 1
    return found


def placing(elastomer: Elastomer) -> Callable[[Any], tuple[Scatterers, Array]] | None:
    """A function that places scatterers in a mesh of a block's cells, or None where its print is clean.

    It gives them, and the volume of bubbles in each cell, shape (cells, 1) [mm3].
    """
    drawn, infill = elastomer.inclusions, elastomer.design.materials.infill
    if drawn is None or infill is None:
        return None

    def placed(shape: Any) -> tuple[Scatterers, Array]:
        positions = np.array(mi.traverse(shape)["vertex_positions"], np.float64)
        found, reflectance = drawn.placed(positions.reshape(-1, 3)), elastomer.design.inclusions.flake_reflectance
        return Scatterers.of(found, drawn.cells, infill.ior, reflectance), found.air_mm3(drawn.cells)[:, None]

    return placed
