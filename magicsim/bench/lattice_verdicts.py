"""How fine must the lattice be? What the detectors read of a pressed ball, against node spacing and time of the solve.

All spacings share seeds of light and of camera noise, so that a row differs from the finest one by its lattice alone.
"""

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from magicsim.bench.compare import machine
from magicsim.bench.verdicts import PROFILE
from magicsim.detectors import detect, fuse, load_profile
from magicsim.scenes.exposure import expose, meter
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation import Sensor

SPACINGS_MM, QUICK_SPACINGS_MM = (3.0, 2.0, 1.5, 1.0, 0.75, 0.5), (3.0, 2.0)
"""Node spacings where contact is; the default design has 1.0. The last one stands for converged."""
DEPTHS_MM = (0.3, 1.0)
REST_SEED = 1_000_000
"""The judged frames are another episode's: their noise differs from the references' by this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LatticeRow:
    """What the detectors read of one depth on one lattice."""

    spacing_mm: float
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
    """All spacings at all depths.

    Args:
        quick: A small image and two coarse lattices.
    """
    spacings = QUICK_SPACINGS_MM if quick else SPACINGS_MM
    rows = [row for spacing in spacings for row in measure_lattice(spacing, quick=quick)]
    return {
        "kind": "lattice",
        "quick": quick,
        "profile": PROFILE,
        "results": [asdict(row) for row in rows],
        "machine": machine(),
    }


def measure_lattice(spacing_mm: float, *, quick: bool = False) -> list[LatticeRow]:
    """The rows of one node spacing.

    Args:
        spacing_mm: Largest node spacing where contact is [mm]; nothing refines it further.
        quick: A small image and a cheap anchor.
    """
    depths = ", ".join(f"{{frame={place}, gap_mm={-depth}}}" for place, depth in enumerate(DEPTHS_MM))
    settings = [
        f"design.lattice.spacing_mm={spacing_mm}", "design.lattice.cells_across=0", f"keyframes=[{depths}]",
    ]  # fmt: skip
    if quick:
        settings += ["rig.camera.columns=60", "rig.camera.rows=80"]
        settings += ["render.anchor_samples=8", "render.anchor_particles=100000"]
    scene, profile = load_scene("pressed", settings), load_profile(PROFILE)
    sensor = Sensor(scene)
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
                spacing_mm=spacing_mm, depth_mm=depth, unknowns=deformation.displacements_mm.size, seconds=seconds,
                force_n=float(np.linalg.norm(deformation.force_n)), entropy=said.entropy,
                correlation=said.correlation, similarity=said.similarity, verdict=said.combined.value,
            )
        )  # fmt: skip
    return rows
