"""The parts of a printed block, each as one closed mesh with a name and a colour to look at."""

from dataclasses import dataclass

import numpy as np

from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh

Colour = tuple[float, float, float, float]
CLEAR: Colour = (0.80, 0.90, 1.00, 0.25)
"""Display colour of skin and walls, RGBA in 0..1."""
TRANSLUCENT: Colour = (1.00, 0.93, 0.75, 0.60)
"""Display colour of the infill."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One material of a print."""

    name: str
    mesh: SurfaceMesh
    """Closed surface in the sensor's frame [mm]."""
    colour: Colour
    """How viewers show it, RGBA in 0..1; no property of the material."""


def printed_parts(elastomer: Elastomer) -> tuple[Part, ...]:
    """The clear part with its cells hollow, then the infill if there is one; they do not overlap."""
    if elastomer.infill is None:
        return (Part(name="body", mesh=elastomer.body, colour=CLEAR),)
    body = _with_cavities(elastomer.body, elastomer.infill)
    return (
        Part(name="body", mesh=body, colour=CLEAR),
        Part(name="infill", mesh=elastomer.infill, colour=TRANSLUCENT),
    )


def _with_cavities(body: SurfaceMesh, infill: SurfaceMesh) -> SurfaceMesh:
    """The body with the infill's surfaces turned inside out, which makes the cells hollow."""
    return SurfaceMesh(
        vertices=np.concatenate([body.vertices, infill.vertices]),
        faces=np.concatenate([body.faces, infill.faces[:, ::-1] + len(body.vertices)]).astype(np.int32),
    )
