"""The part of the contact face that may come into contact, with what contact remembers there."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.contact.face import ContactFace
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.solve.iterate import Iterate

LARGE = 900
"""Unknowns from which the contact of a linearised body costs as much as the body's own factor: below, its matrix is
small change."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FacePart:
    """Some facets of a face."""

    facets: Index
    """Facets of the whole face, ascending."""
    points: Index
    """Contact points on them, ascending."""
    nodes: Index
    """That move those points, ascending, shape (nodes,)."""
    face: ContactFace
    """Those facets alone, patches in terms of `nodes`."""

    @classmethod
    def of(cls, face: ContactFace, facets: Index) -> Self:
        """Some facets.

        Args:
            face: The whole face.
            facets: Ascending.
        """
        nodes = np.unique(face.patches[facets])
        points = np.flatnonzero(np.isin(face.facet, facets))
        part = ContactFace(
            patches=np.searchsorted(nodes, face.patches[facets]),
            facet=np.searchsorted(facets, face.facet[points]),
            shape=face.shape[points],
            slopes=face.slopes[points],
            area_mm2=face.area_mm2[points],
        )
        return cls(facets=facets, points=points, nodes=nodes, face=part)

    @property
    def unknowns(self) -> Index:
        """Numbers of the nodes' unknowns, ascending, shape (3 nodes,)."""
        return np.asarray((3 * self.nodes[:, None] + np.arange(3)).ravel())

    def memory(self, whole: ContactMemory) -> ContactMemory:
        """What contact remembers of these points."""
        excess = whole.limit_excess_mpa
        return replace(
            whole,
            multipliers_mpa=whole.multipliers_mpa[self.points],
            anchors_mm=whole.anchors_mm[self.points],
            limit_mpa=whole.limit_mpa[self.points],
            normal=whole.normal[self.points],
            limit_excess_mpa=None if excess is None else excess[self.points],
        )

    def put_back(self, own: ContactMemory, whole: ContactMemory) -> ContactMemory:
        """The memory of the whole face with that of these points put in."""

        def put(values: Array, part: Array) -> Array:
            result = values.copy()
            result[self.points] = part
            return result

        excess = own.limit_excess_mpa
        return replace(
            own,
            multipliers_mpa=put(whole.multipliers_mpa, own.multipliers_mpa),
            anchors_mm=whole.anchors_mm,
            limit_mpa=put(whole.limit_mpa, own.limit_mpa),
            normal=put(whole.normal, own.normal),
            limit_excess_mpa=None if excess is None else put(np.zeros_like(whole.limit_mpa), excess),
        )


def near_facets(face: ContactFace, iterate: Iterate, near_mm: float) -> Index:
    """Facets with a point in contact, held by friction or near the object, ascending.

    Args:
        face: The whole face.
        iterate: A state.
        near_mm: Distance of points that count as near [mm].
    """
    is_near = iterate.contact.gap_mm < near_mm
    is_near[iterate.contact.acting] = True
    return np.unique(face.facet[is_near])


def is_large(face: ContactFace, facets: Index) -> bool:
    """Whether the contact on some facets is worth thrift.

    Args:
        face: The whole face.
        facets: Some of it, ascending.
    """
    return 3 * len(np.unique(face.patches[facets])) > LARGE
