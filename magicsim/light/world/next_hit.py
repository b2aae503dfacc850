"""The next wall of the grid, found from the cell that a ray is in instead of by a search through all triangles.

A ray inside a convex cell leaves it through one face. A ray that leaves a cell's face runs through the wall behind it,
and nothing lies between that face and the facing one of the next cell; if it meets the latter, that is its next hit.
Both are tests against one face: its vertices are seen along the ray, and the signs of the edges around the ray's origin
tell the triangle (Woop, Benthin and Wald 2013: neighbours share their edges, so that none leaks between them). Where
neither holds (rays along a wall, in the skin, outside), Embree's search finds the hit.

A deformed cell is not quite convex, and a ray might meet a dent first. It leaves the cell through a triangle only
towards the outer side of that triangle's plane, and stays there. So a hit behind all planes of the faces beside it is
the first: `cell_faces` tells how far from them it has to lie for that. Likewise a ray through a wall has not met the
face that it left again if all of the facing face lies in front of all planes of the former; this is asked both ways.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from magicsim.light.backend import VARIANT, dr, mi
from magicsim.light.cells.cell_faces import FRAME, NONE, PACKET, CellFaces
from magicsim.light.cells.cell_topology import FACES, canonical_triangles
from magicsim.light.variant import CUDA_VARIANT

NOWHERE, IN_CELL, IN_WALL = range(3)


@dataclass(slots=True, kw_only=True)
class Whereabouts:
    """Where rays start; every field is a Dr.Jit array over rays."""

    kind: Any
    """`NOWHERE` in particular, `IN_CELL`, or `IN_WALL` on the outside of a cell's face."""
    cell: Any
    face: Any

    @classmethod
    def unknown(cls) -> "Whereabouts":
        """Nowhere in particular."""
        return cls(kind=mi.UInt32(NOWHERE), cell=mi.UInt32(0), face=mi.UInt32(0))


class _View(NamedTuple):
    """A ray in its cell's own frame; lists of three arrays over rays, the last of `CellFaces.frames`."""

    place: list[Any]
    speed: list[Any]
    margin: list[Any]


def whereabouts(si: Any, on_cell: Any, in_cell: Any, leaves: Any, faces: CellFaces | None) -> Whereabouts:
    """Where rays go on from a hit."""
    if faces is None:
        return Whereabouts.unknown()
    per_cell = mi.UInt32(faces.per_cell)
    inside = in_cell | (on_cell & ~leaves)
    return Whereabouts(
        kind=dr.select(inside, mi.UInt32(IN_CELL), dr.select(on_cell, mi.UInt32(IN_WALL), mi.UInt32(NOWHERE))),
        cell=si.prim_index // per_cell,
        face=dr.gather(mi.UInt32, faces.face_of, si.prim_index % per_cell, on_cell),
    )


def next_hit(
    scene: Any, ray: Any, body: Any, infill: Any, faces: CellFaces | None, at: Whereabouts, active: Any
) -> Any:
    """Surface interaction at the end of each ray."""
    if faces is None:
        return searched(scene, ray, body, infill, active)
    patch, axis, view = _face_ahead(ray, faces, at)
    across = (at.kind == IN_WALL) & (patch != NONE)
    found, distance, triangle = _meet(ray, faces, patch, at.kind == IN_CELL, active & ((at.kind == IN_CELL) | across))
    found &= across | _is_first(view, axis, distance)
    si = searched(scene, ray, body, infill, active & ~found)
    place = patch * faces.per_face + triangle
    frame = mi.Frame3f(mi.Normal3f(dr.gather(mi.Vector4f, faces.normals, place, found).xyz))
    si.t = dr.select(found, distance, si.t)
    si.p = dr.select(found, ray(distance), si.p)
    si.n = dr.select(found, frame.n, si.n)
    si.sh_frame = dr.select(found, frame, si.sh_frame)
    si.wi = dr.select(found, frame.to_local(-ray.d), si.wi)
    index = (patch // FACES) * faces.per_cell + dr.gather(mi.UInt32, faces.triangles, place % faces.per_cell, found)
    si.prim_index = dr.select(found, index, si.prim_index)
    si.shape = dr.select(found, infill, si.shape)
    return si


def searched(scene: Any, ray: Any, body: Any, infill: Any, active: Any) -> Any:
    """The hit that a search among all shapes finds, without texture coordinates, which flat shapes need not."""
    found = scene.ray_intersect_preliminary(ray, coherent=False, active=active)
    # The block's group stands where it was made: what is found in it needs no transform.
    if VARIANT != CUDA_VARIANT:  # Embree tells a shape's place in its group; OptiX the shape itself, and no place
        grouped = found.instance != dr.zeros(mi.ShapePtr)
        found.shape = dr.select(grouped, dr.select(found.shape_index == 0, body, infill), found.shape)
    found.instance = dr.zeros(mi.ShapePtr)
    return flat(found.compute_surface_interaction(ray, mi.RayFlags.Minimal, active), ray)


def flat(si: Any, ray: Any) -> Any:
    """A hit whose local frame follows from the normal alone, so that no search tells in which scene it was found."""
    si.sh_frame = mi.Frame3f(si.n)
    si.wi = dr.select(si.is_valid(), si.to_local(-ray.d), -ray.d)  # the room is looked up by it
    return si


def _face_ahead(ray: Any, faces: CellFaces, at: Whereabouts) -> tuple[Any, Any, _View]:
    """Number of the face that a ray probably meets next, `NONE` where unknown; in a cell its axis, and the ray."""
    in_cell = at.kind == IN_CELL
    frame = _fetch(faces.frames, at.cell * FRAME, FRAME, in_cell)
    rows = [mi.Vector3f(*frame[3 * axis : 3 * axis + 3]) for axis in range(3)]
    start, way = ray.o - mi.Point3f(*frame[9:12]), ray.d
    view = _View([dr.dot(row, start) for row in rows], [dr.dot(row, way) for row in rows], frame[12:15])
    steps = [(1 - dr.mulsign(p, v)) / dr.maximum(dr.abs(v), 1e-9) for p, v in zip(view.place, view.speed, strict=True)]
    nearest = dr.minimum(dr.minimum(steps[0], steps[1]), steps[2])
    axis, ahead = mi.UInt32(0), mi.UInt32(0)
    for number, speed in enumerate(view.speed):
        is_next = steps[number] == nearest
        axis = dr.select(is_next, mi.UInt32(number), axis)
        ahead = dr.select(is_next, 2 * number + dr.select(speed > 0, mi.UInt32(1), mi.UInt32(0)), ahead)
    across = dr.gather(mi.UInt32, faces.neighbours, at.cell * FACES + at.face, at.kind == IN_WALL)
    across = dr.select(across == NONE, mi.UInt32(NONE), across * FACES + (at.face ^ 1))
    return dr.select(in_cell, at.cell * FACES + ahead, across), axis, view


def _is_first(view: _View, axis: Any, distance: Any) -> Any:
    """Whether a ray that leaves its cell through a face of an axis cannot have met another face before."""
    clear = mi.Bool(True)
    for number in range(3):
        end = dr.abs(dr.fma(view.speed[number], distance, view.place[number]))
        clear &= (axis == number) | (end < 1 - view.margin[number])
    return clear


def _meet(ray: Any, faces: CellFaces, patch: Any, from_inside: Any, active: Any) -> tuple[Any, Any, Any]:
    """Nearest triangle of a face that a ray meets from the asked side: whether there is one, how far, its number."""
    points = (faces.parts + 1) ** 2
    values = _fetch(faces.patches, patch * faces.stride, faces.stride, active)
    across, up = mi.coordinate_system(ray.d)
    corners = [mi.Vector3f(*values[3 * k : 3 * k + 3]) - ray.o for k in range(points)]
    x, y, z = ([dr.dot(corner, axis) for corner in corners] for axis in (across, up, ray.d))
    edges: dict[tuple[int, int], Any] = {}

    def edge(a: int, b: int) -> Any:
        if (b, a) in edges:
            return -edges[b, a]
        if (a, b) not in edges:
            edges[a, b] = dr.fma(x[a], y[b], -x[b] * y[a])
        return edges[a, b]

    nearest, triangle = mi.Float(dr.inf), mi.UInt32(0)
    for number, (a, b, c) in enumerate(canonical_triangles(faces.parts).tolist()):
        # The outward side turns counter-clockwise about a ray that goes out.
        weights = [dr.select(from_inside, weight, -weight) for weight in (edge(b, c), edge(c, a), edge(a, b))]
        total = weights[0] + weights[1] + weights[2]
        depth = dr.fma(weights[0], z[a], dr.fma(weights[1], z[b], weights[2] * z[c])) / total
        hit = (weights[0] >= 0) & (weights[1] >= 0) & (weights[2] >= 0) & (total > 0)
        hit &= (depth >= 0) & (depth < nearest)
        nearest = dr.select(hit, depth, nearest)
        triangle = dr.select(hit, mi.UInt32(number), triangle)
    return active & (nearest < dr.inf), nearest, triangle


def _fetch(source: Any, first: Any, count: int, active: Any) -> list[Any]:
    """Consecutive floats, `PACKET` at a time."""
    packets = [dr.gather(mi.Vector4f, source, first // PACKET + k, active) for k in range(count // PACKET)]
    return [packet[lane] for packet in packets for lane in range(PACKET)]
