"""Triangles of one face of a block divided into smaller ones, while the rest of the block stays as it is.

Around what presses, the face bends over tenths of a millimetre, and each flat triangle would be a facet of its own to
the light. Every triangle of the face becomes a triangular lattice of smaller ones; triangles that stand on its rim
become fans over the divided edge, so that the mesh stays closed.
"""

from collections.abc import Callable

import numpy as np

from magicsim.arrays import Index, Mask
from magicsim.geometry.mesh import SurfaceMesh

EDGES = ((0, 1), (1, 2), (2, 0))


def refined_face(mesh: SurfaceMesh, is_face: Mask, parts: int) -> SurfaceMesh:
    """The mesh with the edges of one face divided.

    Args:
        mesh: Closed mesh.
        is_face: Which vertices lie on the face, its rim included, shape (vertices,); triangles beside it have two of
            them at most.
        parts: Into how many equal parts every edge of the face is divided, at least 1.

    Returns:
        A closed mesh of the same surface. The vertices of `mesh` come first, in their order.
    """
    if parts == 1:
        return mesh
    faces = mesh.faces.astype(np.int64)
    off = (~is_face[faces]).sum(1)
    whole, rim, others = faces[off == 0], faces[off == 1], faces[off > 1]
    edges = np.unique(np.sort(whole[:, EDGES].reshape(-1, 2), axis=1), axis=0)
    keys, count = edges[:, 0] * len(mesh.vertices) + edges[:, 1], len(mesh.vertices)

    def between(start: Index, end: Index) -> Index:
        """Vertices along edges of the face, their ends included, shape (edges, parts + 1)."""
        low, high = np.minimum(start, end), np.maximum(start, end)
        number = np.searchsorted(keys, low * len(mesh.vertices) + high)
        inner = count + number[:, None] * (parts - 1) + np.arange(parts - 1)
        inner = np.where((start < end)[:, None], inner, inner[:, ::-1])
        return np.concatenate([start[:, None], inner, end[:, None]], axis=1)

    # where the lattice's points lie, in steps from the first corner towards the second and the third
    steps = [(i, j) for j in range(parts + 1) for i in range(parts + 1 - j)]
    place = {step: number for number, step in enumerate(steps)}
    inside = [step for step in steps if min(*step, parts - sum(step)) > 0]
    first_inside = count + len(edges) * (parts - 1)
    lattice = np.empty((len(whole), len(steps)), np.int64)
    a, b, c = whole.T
    for number in range(parts + 1):
        lattice[:, place[number, 0]] = between(a, b)[:, number]
        lattice[:, place[0, number]] = between(a, c)[:, number]
        lattice[:, place[parts - number, number]] = between(b, c)[:, number]
    lattice[:, [place[step] for step in inside]] = (
        first_inside + np.arange(len(whole))[:, None] * len(inside) + np.arange(len(inside))
    )
    small = [
        (place[i, j], place[i + 1, j], place[i, j + 1]) for i, j in steps if i + j < parts
    ] + [
        (place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]) for i, j in steps if i + j < parts - 1
    ]  # fmt: skip

    share = np.arange(1, parts) / parts
    one, other = mesh.vertices[edges].transpose(1, 0, 2)
    along = one[:, None] + share[:, None] * (other - one)[:, None]
    weights = np.array([(parts - i - j, i, j) for i, j in inside]).reshape(-1, 3) / parts
    within = np.einsum("sk,tkc->tsc", weights, mesh.vertices[whole])
    return SurfaceMesh(
        vertices=np.concatenate([mesh.vertices, along.reshape(-1, 3), within.reshape(-1, 3)]),
        faces=np.concatenate(
            [others, lattice[:, small].reshape(-1, 3), _fans(rim, is_face, between)]
        ).astype(np.int32),
    )  # fmt: skip


def _fans(rim: Index, is_face: Mask, between: Callable[[Index, Index], Index]) -> Index:
    """Triangles beside the face, each from its corner off the face over its divided edge, shape (triangles, 3)."""
    apex = np.argmin(is_face[rim], axis=1)
    turned = np.take_along_axis(rim, (apex[:, None] + np.arange(3)) % 3, axis=1)
    chain = between(turned[:, 1], turned[:, 2])
    tips = np.repeat(turned[:, :1], chain.shape[1] - 1, axis=1)
    return np.stack([tips, chain[:, :-1], chain[:, 1:]], axis=-1).reshape(-1, 3)
