"""How fine must the lattice be? What the detectors read of a pressed ball, against unknowns and time of the solve.

Planes of the printed grid are planes of the lattice, so nothing is coarser than one cell to a node; below that, only a
whole part of a cell is another lattice. All lattices share seeds of light and of camera noise, so that a row differs
from the finest one by its lattice alone.
"""

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from laboratory.benchmark import logged, machine
from laboratory.light.verdicts import PROFILE
from magicsim.camera.exposure import expose, meter
from magicsim.detectors import detect, fuse, load_profile
from magicsim.light.records.untouched_store import shared_states
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.sensor import Sensor

LATTICES = ((1.0, 3.0), (1.0, 1.6), (0.5, 1.6), (0.34, 1.6))
"""Node spacing where contact is [mm], and growth of the spacings away from there; the second is the default design's,
the last one stands for converged."""
DEPTHS_MM = (0.3, 1.0)
REST_SEED = 1_000_000
"""The judged frames are another episode's: their noise differs from the references' by this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LatticeRow:
    """What the detectors read of one depth on one lattice."""

    spacing_mm: float
    growth: float
    """Ratio of neighbouring spacings away from the contact."""
    depth_mm: float
    unknowns: int
    """Displacement unknowns, where contact is and far from it."""
    seconds: float
    """Time of the solve, from the depth before."""
    force_n: float
    entropy: float
    correlation: float
    similarity: float
    verdict: str


def run_lattice(*, quick: bool = False) -> dict[str, Any]:
    """All lattices at all depths.

    Args:
        quick: A small image and two coarse lattices.
    """
    lattices = LATTICES[:2] if quick else LATTICES
    rows = logged(row for each in lattices for row in measure_lattice(*each, quick=quick))
    return {
        "kind": "lattice",
        "quick": quick,
        "profile": PROFILE,
        "results": [asdict(row) for row in rows],
        "machine": machine(),
    }


def measure_lattice(spacing_mm: float, growth: float, *, quick: bool = False) -> list[LatticeRow]:
    """The rows of one lattice.

    Args:
        spacing_mm: Largest node spacing where contact is [mm]; nothing refines it further.
        growth: Ratio of neighbouring spacings away from there.
        quick: A small image and a cheap anchor.
    """
    depths = ", ".join(f"{{frame={place}, gap_mm={-depth}}}" for place, depth in enumerate(DEPTHS_MM))
    settings = [
        f"design.lattice.spacing_mm={spacing_mm}", f"design.lattice.growth={growth}",
        "design.lattice.cells_across=0", f"keyframes=[{depths}]",
    ]  # fmt: skip
    if quick:
        settings += ["rig.camera.columns=60", "rig.camera.rows=80"]
        settings += ["render.anchor_samples=8", "render.anchor_particles=100000"]
    scene, profile = load_scene("pressed", settings), load_profile(PROFILE)
    sensor = Sensor.for_scene(scene, untouched=shared_states())
    untouched, camera = sensor.radiance(UNTOUCHED, sensor.rest), scene.rig.camera
    exposure, count = meter(untouched, camera), profile.reference_count
    references = fuse(
        [expose(untouched, exposure, camera, seed=scene.seed, frame=number) for number in range(count)], profile
    )
    rows, deformation = [], sensor.rest
    for place, (state, depth) in enumerate(zip(timeline(scene), DEPTHS_MM, strict=True)):
        start = time.perf_counter()
        deformation = sensor.deform(state, deformation)
        seconds = time.perf_counter() - start
        radiance = sensor.radiance(state, deformation)
        image = expose(radiance, exposure, camera, seed=scene.seed + REST_SEED, frame=count + place)
        said = detect(image, references, profile)
        rows.append(
            LatticeRow(
                spacing_mm=spacing_mm, growth=growth, depth_mm=depth, unknowns=deformation.displacements_mm.size,
                seconds=seconds,
                force_n=float(np.linalg.norm(deformation.force_n)), entropy=said.entropy,
                correlation=said.correlation, similarity=said.similarity, verdict=said.combined.value,
            )
        )  # fmt: skip
    return rows
