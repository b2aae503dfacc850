"""Figures that say how far a deformation can be trusted, and what it took."""

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class SolveFigures:
    """How trustworthy a deformation is."""

    iterations: int
    """Newton iterations of a solve or along a path, cut-backs included; 0 where nothing was solved."""
    min_jacobian: float
    """Smallest Jacobian at any Gauss point."""
    max_penetration_mm: float
    """Deepest contact point inside the object [mm]."""
    force_balance: float
    """|contact force + reaction of the base| / |contact force|; 0 without contact."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PathFigures(SolveFigures):
    """What a solve or a path took."""

    cutbacks: int
    """Load steps that had to be halved."""
    restarts: int
    """Parts that were begun again from rest, with longer steps and then with shorter ones."""
    shifted: int
    """Iterations whose matrix was not positive definite before a multiple of the spring Laplacian was added."""
    rungs: tuple[str, ...]
    """What it took beyond the ordinary way, see `magicsim.deform.solve.ladder`."""
    unknowns: int
    """Displacement unknowns."""
    converged: bool
    """Always true: a solve that is not valid raises."""


def figures_last(result: SolveFigures) -> dict[str, Any]:
    """All fields of a result: its own first, the figures that it shares with others after them."""
    found = asdict(result)
    return {name: found[name] for name in type(result).__slots__} | found
