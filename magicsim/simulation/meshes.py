"""How the rendered meshes follow the lattice, and how the skin fits to what touches it."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Mask
from magicsim.deform.contact.face import face_weights
from magicsim.deform.lattice.follow import CellCorrectors, FollowMap, cell_correctors, follow_map
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.indenter import Indenter
from magicsim.light.world.lamp_shapes import marker_disks
from magicsim.scenes.scene import ContactSettings
from magicsim.simulation.skin import check_skin, settle, still

WET_OVERLAP_MM = 0.008
"""How far the object's surface stands out of the skin where they are in optical contact [mm]: more than the
3 micrometres that `volpath` needs to see them as one."""


def marker_map(design: ElastomerDesign, lattice: Lattice) -> FollowMap | None:
    """How the centres of a block's markers follow its lattice; None without markers."""
    if design.markers is None:
        return None
    places = design.markers.centres_mm(design.footprint_mm)
    rest = np.column_stack([places, np.full(len(places), design.markers.depth_mm)])
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
        still_mm: Displacements up to this are left out (`magicsim.simulation.skin.still`) [mm].

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
    distance = indenter.distance
    body = settle(followed, meshes.is_face, distance, clearance)
    if contact.coupling == "dry":
        middles = (body[meshes.face_edges[:, 0]] + body[meshes.face_edges[:, 1]]) / 2
        clearance += max(0.0, clearance - float(distance(middles)[0].min()))
        body = settle(followed, meshes.is_face, distance, clearance)
    if meshes.infill is None:
        return body, None
    infill = still(meshes.infill.displaced(displacements_mm), meshes.infill.points_mm, still_mm)
    check_skin(infill, distance, clearance)
    return body, settle(infill, np.zeros(len(infill), bool), distance, clearance)
