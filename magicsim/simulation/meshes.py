"""How the rendered meshes follow the lattice, and how the skin fits to what touches it.

The lattice is coarser than the surface that is rendered. Contact is solved at points, to a tolerance; between them, and
between the vertices that are rendered, a face cuts into a curved object by up to spacing^2 / (8 radius). `settle` moves
face points along the object's normal to a stated clearance: positive leaves a thin gap (optically dry), negative lets
the object's surface stand out of the face (optically wet).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Mask
from magicsim.deform.contact.face import face_weights
from magicsim.deform.deformation import TOUCHING_GAP_MM
from magicsim.deform.lattice.follow import CellCorrectors, FollowMap, cell_correctors, follow_map
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.indenter import Indenter
from magicsim.light.safe_gap import check_skin
from magicsim.light.world.lamp_shapes import marker_disks
from magicsim.scenes.scene import ContactSettings
from magicsim.simulation.unmoved import still

WET_OVERLAP_MM = 0.008
"""How far the object's surface stands out of the skin where they are in optical contact [mm]: more than the
3 micrometres that `volpath` needs to see them as one."""
FACE_BAND_MM = 0.03
"""Width of the zone beyond what touches in which a face point's correction fades out [mm]: a wider one would close gaps
that are open."""
BAND_MM = 0.2
"""Width of the zone in which the correction of points behind the face fades out [mm]."""
ITERATIONS = 4
"""Corrections along the normal; one is exact on planes and spheres, rounded edges need a few."""


class MarkerTracks:
    """Markers of one sensor as they move with its lattice."""

    def __init__(self, design: ElastomerDesign, lattice: Lattice) -> None:
        """Hangs the markers on the lattice.

        Args:
            design: A block with markers.
            lattice: The lattice that is solved.
        """
        assert design.markers is not None
        places = design.markers.centres_mm(design.footprint_mm)
        rest = np.column_stack([places, np.full(len(places), design.markers.depth_mm)])
        on_face = design.markers.depth_mm == 0
        self._follow = (
            FollowMap(points_mm=rest, weights=face_weights(lattice, places)) if on_face else follow_map(lattice, rest)
        )

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice) -> Self | None:
        """Those of a block, or None where it has none."""
        return cls(design, lattice) if design.markers is not None else None

    @property
    def rest_mm(self) -> Array:
        """Centres of the undisplaced markers, shape (markers, 3) [mm]."""
        return self._follow.points_mm

    def displaced_mm(self, displacements_mm: Array) -> Array:
        """Centres under nodal displacements of shape (nodes, 3), shape (markers, 3) [mm]."""
        return self._follow.displaced(displacements_mm)


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
    """Markers below the face."""
    face_edges: npt.NDArray[np.int32]
    """Edges of the contact face's triangles, where they cut deepest into a convex object, shape (edges, 2)."""


def attach_meshes(elastomer: Elastomer, lattice: Lattice) -> Meshes:
    """Hangs the meshes of an elastomer on its lattice."""
    body = elastomer.body.vertices
    is_face = elastomer.is_face
    disks_below = marker_disks(elastomer.design)
    triangles = elastomer.body.faces[is_face[elastomer.body.faces].all(1)]
    return Meshes(
        body=follow_map(lattice, body),
        face=FollowMap(points_mm=body[is_face], weights=face_weights(lattice, body[is_face, :2])),
        infill=_attach_infill(elastomer, lattice),
        is_face=is_face,
        markers=follow_map(lattice, disks_below.vertices) if disks_below is not None else None,
        face_edges=triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2),
    )


def _attach_infill(elastomer: Elastomer, lattice: Lattice) -> CellCorrectors | None:
    if elastomer.infill is None or elastomer.grid is None:
        return None
    cells = elastomer.infill.vertices
    return cell_correctors(elastomer.design, elastomer.grid, lattice, cells, elastomer.drawn_cell_mm)


def deformed_vertices(
    meshes: Meshes, displacements_mm: Array, indenter: Indenter | None, contact: ContactSettings, *, still_mm: float
) -> tuple[Array, Array | None]:
    """Vertices of body and infill on a displaced lattice, the skin fitted to the object.

    Args:
        meshes: How they hang on the lattice.
        displacements_mm: Displacements of the lattice's nodes, shape (nodes, 3) [mm].
        indenter: The object where it is, None where a dent is left without one.
        contact: How skin and object meet.
        still_mm: Displacements up to this are left out (`magicsim.simulation.unmoved`) [mm].

    Returns:
        Body vertices, shape (body vertices, 3) [mm], and infill vertices or None without a grid.

    Raises:
        RenderError: The object reaches a cell through the skin.
    """
    clearance = -WET_OVERLAP_MM if contact.coupling == "wet" else contact.film_mm
    followed = meshes.body.displaced(displacements_mm)
    followed[meshes.is_face] = meshes.face.displaced(displacements_mm)
    followed = still(followed, meshes.body.points_mm, still_mm)
    if indenter is None:
        if meshes.infill is None:
            return followed, None
        return followed, still(meshes.infill.displaced(displacements_mm), meshes.infill.points_mm, still_mm)
    body = settle(followed, meshes.is_face, indenter, clearance)
    if contact.coupling == "dry":
        middles = (body[meshes.face_edges[:, 0]] + body[meshes.face_edges[:, 1]]) / 2
        clearance += max(0.0, clearance - float(indenter.distance(middles)[0].min()))
        body = settle(followed, meshes.is_face, indenter, clearance)
    if meshes.infill is None:
        return body, None
    infill = still(meshes.infill.displaced(displacements_mm), meshes.infill.points_mm, still_mm)
    check_skin(infill, indenter, clearance)
    return body, settle(infill, np.zeros(len(infill), bool), indenter, clearance)


def settle(
    points_mm: Array,
    is_face: Mask,
    indenter: Indenter,
    clearance_mm: float,
) -> Array:
    """Moves points near an object so that the face keeps its clearance and nothing behind it is inverted.

    Face points with a distance of at most `TOUCHING_GAP_MM`, or of the clearance, end at `clearance_mm`; the correction
    fades smoothly over `FACE_BAND_MM`. Other points are pushed strictly beyond the clearance, in the order of their
    distance.

    Args:
        points_mm: Deformed positions, shape (points, 3) [mm].
        is_face: Which of them lie on the contact face, shape (points,).
        indenter: The object in its pose.
        clearance_mm: Distance of touching face points from the object's surface [mm]; negative is inside.
    """
    settled = np.array(points_mm, dtype=np.float64)
    distance, normal = indenter.distance(settled)
    touch = max(TOUCHING_GAP_MM, clearance_mm)
    near = np.flatnonzero(distance < touch + BAND_MM)
    if len(near) == 0:
        return settled
    target = np.where(
        is_face[near],
        face_distance(distance[near], clearance_mm, touch),
        interior_distance(distance[near], clearance_mm),
    )
    moved, now, along = settled[near], distance[near], normal[near]
    for _ in range(ITERATIONS):
        moved = moved + (target - now)[:, None] * along
        now, along = indenter.distance(moved)
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
