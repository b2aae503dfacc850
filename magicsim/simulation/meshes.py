"""How the rendered meshes follow the lattice, and how the skin fits to what touches it.

The lattice is coarser than the surface that is rendered. Contact is solved at points, to a tolerance; between them, and
between the vertices that are rendered, a face cuts into a curved object by up to spacing^2 / (8 radius). `settle` moves
face points along the object's normal to a stated clearance: positive leaves a thin gap (optically dry), negative lets
the object's surface stand out of the face (optically wet). Walls that the renderer cannot tell apart would let light
through, and must not become an image.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Mask
from magicsim.deform.contact.face import face_weights
from magicsim.deform.deformation import TOUCHING_GAP_MM
from magicsim.deform.lattice.follow import CellCorrectors, FollowMap, cell_correctors, follow_map
from magicsim.deform.lattice.structure import Lattice
from magicsim.errors import RenderError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.grid import CellGrid
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.printed_cells import facing_vertices
from magicsim.light.world.lamp_shapes import marker_disks
from magicsim.scenes.scene import ContactSettings

Distance = Callable[[Array], tuple[Array, Array]]
FACE_BAND_MM = 0.03
"""Width of the zone beyond what touches in which a face point's correction fades out [mm]: a wider one would close gaps
that are open."""
BAND_MM = 0.2
"""Width of the zone in which the correction of points behind the face fades out [mm]."""
ITERATIONS = 4
"""Corrections along the normal; one is exact on planes and spheres, rounded edges need a few."""
FADE = 8.0
"""Displacement, in units of the bound, from which on it is rendered as it is: strains grow by 22 % at most."""
SAFE_GAP_MM = 0.01
"""Least thickness of a wall [mm]: rays leave surfaces by 0.15 micrometres (`volpath`: 1.5), and flat walls of 0.5 keep
a white furnace within 0.1 %; the rest is a margin for bent ones."""


def settle(points_mm: Array, is_face: Mask, distance: Distance, clearance_mm: float) -> Array:
    """Moves points near an object so that the face keeps its clearance and nothing behind it is inverted.

    Face points with a distance of at most `TOUCHING_GAP_MM`, or of the clearance, end at `clearance_mm`; the correction
    fades smoothly over `FACE_BAND_MM`. Other points are pushed strictly beyond the clearance, in the order of their
    distance.

    `distance` is from the object in its pose, see `Indenter.distance`; a negative clearance is inside.
    """
    settled = np.array(points_mm, dtype=np.float64)
    away, normal = distance(settled)
    touch = max(TOUCHING_GAP_MM, clearance_mm)
    near = np.flatnonzero(away < touch + BAND_MM)
    if len(near) == 0:
        return settled
    target = np.where(
        is_face[near], face_distance(away[near], clearance_mm, touch), interior_distance(away[near], clearance_mm)
    )
    moved, now, along = settled[near], away[near], normal[near]
    for _ in range(ITERATIONS):
        moved = moved + (target - now)[:, None] * along
        now, along = distance(moved)
    settled[near] = moved
    return settled


def face_distance(distance: Array, clearance_mm: float, touch_mm: float) -> Array:
    """Distance after settling: the clearance up to `touch_mm`, unchanged from `FACE_BAND_MM` beyond, a cubic between.

    Once differentiable and increasing for clearance <= touch.
    """
    t = np.clip((distance - touch_mm) / FACE_BAND_MM, 0, 1)
    end = touch_mm + FACE_BAND_MM
    blended = clearance_mm + (end - clearance_mm) * t**2 * (3 - 2 * t) + FACE_BAND_MM * t**2 * (t - 1)
    return np.asarray(np.where(distance >= end, distance, blended))


def interior_distance(distance: Array, clearance_mm: float) -> Array:
    """Distance of interior points after settling: strictly increasing, above the clearance, unchanged far away."""
    beyond = distance - clearance_mm
    lifted = (beyond + np.sqrt(beyond**2 + (BAND_MM / 4) ** 2)) / 2
    t = np.clip(beyond / BAND_MM, 0, 1)
    fade = t**2 * (3 - 2 * t)
    return np.asarray(clearance_mm + (1 - fade) * lifted + fade * beyond)


def still(vertices: Array, rest: Array, bound_mm: float) -> Array:
    """Vertices less the part of their displacement that is left out, which is nowhere more than the bound.

    After a few refractions a displacement of a micrometre sends a path through another cell. Rendered as they are, such
    displacements would change nothing that can be seen but every random choice, all over the image: its noise would
    tell that something touches.

    Up to the bound all of a displacement is left out, beyond it as much as the bound at first and then less and less.
    """
    if bound_mm == 0:
        return vertices
    moved = vertices - rest
    way = np.linalg.norm(moved, axis=1, keepdims=True)
    t = np.clip((way / bound_mm - 1) / (FADE - 1), 0, 1)
    kept = np.maximum(way - bound_mm * (1 - t * t * (3 - 2 * t)), 0)
    return np.asarray(rest + moved * np.divide(kept, way, out=np.zeros_like(way), where=way > 0))


def check_walls(infill: Array, rest: SurfaceMesh, grid: CellGrid) -> None:
    """Refuses (`RenderError`) a deformed grid with a wall below the safe gap, of so much and there."""
    thickness, place = thinnest_wall(infill, rest, grid)
    if thickness < SAFE_GAP_MM:
        raise RenderError(_message("wall", thickness, place, "wall_mm"))


def check_skin(infill: Array, distance: Distance, clearance_mm: float) -> None:
    """Refuses (`RenderError`) cells that the object reaches through the skin, so thin and there."""
    skin = distance(infill)[0] - max(clearance_mm, 0.0)
    thinnest = int(skin.argmin())
    if skin[thinnest] < SAFE_GAP_MM:
        raise RenderError(_message("skin", float(skin[thinnest]), infill[thinnest], "skin_mm"))


def _message(part: str, thickness: float, place: Array, field: str) -> str:
    x, y, z = place.round(2).tolist()
    return (
        f"the {part} near ({x:g}, {y:g}, {z:g}) mm is squeezed to {1e3 * thickness:.1f} micrometres: must stay above "
        f"{1e3 * SAFE_GAP_MM:g}, or light leaks through; press less or print {field} thicker"
    )


def thinnest_wall(infill: Array, rest: SurfaceMesh, grid: CellGrid) -> tuple[float, Array]:
    """Thickness of the thinnest wall between neighbouring cells [mm], or infinity, and its middle, shape (3,) [mm].

    Facing vertices of two neighbours differ by the wall; its thickness is their distance along the wall's normal, the
    mean normal of the two faces. Negative where cells overlap.
    """
    nx, ny, nz = grid.counts
    cell = rest.vertices.reshape(grid.cell_count, -1, 3)[0]
    moved = infill.reshape(nz, ny, nx, -1, 3)
    least, where = np.inf, np.zeros(3)
    for axis in range(3):
        if grid.counts[axis] == 1:
            continue
        high, low = facing_vertices(cell, axis)
        ahead = np.moveaxis(moved, 2 - axis, 0)
        near, far = ahead[:-1][..., high, :], ahead[1:][..., low, :]
        across = (far - near).reshape(-1, len(high), 3)
        normal = _normals(near, cell[high], axis) + _normals(far, cell[low], axis)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        thickness = np.einsum("wvi,wi->wv", across, normal.reshape(-1, 3))
        wall, vertex = np.unravel_index(thickness.argmin(), thickness.shape)
        if thickness[wall, vertex] < least:
            least = float(thickness[wall, vertex])
            where = ((near + far) / 2).reshape(-1, len(high), 3)[wall, vertex]
    return least, where


def _normals(faces: Array, rest: Array, axis: int) -> Array:
    """Mean normals of deformed faces along the positive axis, shape (..., 3), from their extreme corners' diagonals."""
    across = np.delete(rest, axis, axis=1)
    sums, differences = across.sum(1), across[:, 0] - across[:, 1]
    one = faces[..., sums.argmax(), :] - faces[..., sums.argmin(), :]
    other = faces[..., differences.argmax(), :] - faces[..., differences.argmin(), :]
    normal = np.cross(other, one)
    sign = (1, -1, 1)[axis]
    return np.asarray(sign * normal / np.linalg.norm(normal, axis=-1, keepdims=True))


WET_OVERLAP_MM = 0.008
"""How far the object's surface stands out of the skin where they are in optical contact [mm]: more than the
3 micrometres that `volpath` needs to see them as one."""


def marker_map(design: ElastomerDesign, lattice: Lattice) -> FollowMap | None:
    """How the centres of a block's markers follow its lattice; None without markers."""
    if design.markers is None:
        return None
    places = design.markers.centres_mm(design.footprint_mm)
    rest = design.lifted(np.column_stack([places, np.full(len(places), design.markers.depth_mm)]))
    if design.markers.depth_mm == 0:
        return FollowMap(points_mm=rest, weights=face_weights(lattice, places))
    return follow_map(lattice, rest)


@dataclass(frozen=True, slots=True, kw_only=True)
class Meshes:
    """How the rendered meshes hang on the lattice."""

    body: FollowMap
    face: FollowMap
    """The body's vertices on the contact face, which follow it as the contact points do."""
    infill: CellCorrectors | None
    is_face: Mask
    """Body vertices on the contact face, shape (body vertices,)."""
    markers: FollowMap | None
    face_edges: npt.NDArray[np.int32]
    """Edges of the contact face's triangles, where they cut deepest into a convex object, shape (edges, 2)."""


def attach_meshes(elastomer: Elastomer, lattice: Lattice) -> Meshes:
    """Hangs the meshes of an elastomer on its lattice."""
    body = elastomer.body.vertices
    is_face = elastomer.is_face
    disks_below = marker_disks(elastomer.design)
    triangles = elastomer.body.faces[is_face[elastomer.body.faces].all(1)]
    infill, cells, grid = None, elastomer.infill, elastomer.grid
    if cells is not None and grid is not None:
        infill = cell_correctors(elastomer.design, grid, lattice, cells.vertices, elastomer.drawn_cell_mm)
    return Meshes(
        body=follow_map(lattice, body), infill=infill, is_face=is_face,
        face=FollowMap(points_mm=body[is_face], weights=face_weights(lattice, body[is_face, :2])),
        markers=follow_map(lattice, disks_below.vertices) if disks_below is not None else None,
        face_edges=triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2),
    )  # fmt: skip


def deformed_vertices(
    meshes: Meshes, displacements_mm: Array, indenter: Indenter | None, contact: ContactSettings, *, still_mm: float
) -> tuple[Array, Array | None]:
    """Vertices of body and infill on a displaced lattice, the skin fitted to the object.

    Args:
        meshes: How they hang on the lattice.
        displacements_mm: Displacements of the lattice's nodes, shape (nodes, 3) [mm].
        indenter: The object where it is, None where a dent is left without one.
        contact: How skin and object meet.
        still_mm: Displacements up to this are left out (`magicsim.simulation.meshes.still`) [mm].

    Returns:
        Body vertices, shape (body vertices, 3) [mm], and infill vertices or None without a grid.

    Raises:
        RenderError: The object reaches a cell through the skin.
    """
    clearance = -WET_OVERLAP_MM if contact.coupling == "wet" else contact.film_mm
    followed = meshes.body.displaced(displacements_mm)
    followed[meshes.is_face] = meshes.face.displaced(displacements_mm)
    followed = still(followed, meshes.body.points_mm, still_mm)
    infill = None
    if meshes.infill is not None:
        infill = still(meshes.infill.displaced(displacements_mm), meshes.infill.points_mm, still_mm)
    if indenter is None:
        return followed, infill
    distance = indenter.distance
    body = settle(followed, meshes.is_face, distance, clearance)
    if contact.coupling == "dry":
        middles = (body[meshes.face_edges[:, 0]] + body[meshes.face_edges[:, 1]]) / 2
        clearance += max(0.0, clearance - float(distance(middles)[0].min()))
        body = settle(followed, meshes.is_face, distance, clearance)
    if infill is None:
        return body, None
    check_skin(infill, distance, clearance)
    return body, settle(infill, np.zeros(len(infill), bool), distance, clearance)
