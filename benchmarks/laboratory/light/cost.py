"""Cost of light against work: seconds of one image against the number of cells, of pixels, samples and particles."""

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from laboratory.benchmark import logged, machine
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor

REPEATS = 5
DEFAULT = {"cell_mm": 0.8, "columns": 240, "samples": 8, "particles": 80_000}
SWEEPS: dict[str, tuple[float, ...]] = {
    "cell_mm": (2.0, 1.2, 0.8, 0.5, 0.35),
    "columns": (60, 120, 240, 480),
    "samples": (2, 8, 16, 64),
    "particles": (20_000, 80_000, 320_000, 1_280_000),
}
"""What is varied, one at a time; the rest is `DEFAULT`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LightCostRow:
    """One size; medians of seconds, everything compiled."""

    varied: str
    cell_mm: float
    columns: int
    samples: int
    particles: int
    cells: int
    triangles: int
    """Of body and infill."""
    seconds_update: float
    """New vertices and the search tree over them."""
    seconds_image: float
    """Light pass and camera pass."""


def run_light_cost(*, quick: bool = False) -> dict[str, Any]:
    """All sweeps.

    Args:
        quick: Two sizes of each, small ones.
    """
    sizes = [(varied, value) for varied, values in SWEEPS.items() for value in (values[:2] if quick else values)]
    rows = logged(measure_light_cost(varied, value, repeats=2 if quick else REPEATS) for varied, value in sizes)
    exponents = {varied: _exponent(varied, [row for row in rows if row.varied == varied]) for varied in SWEEPS}
    return {
        "kind": "light-cost",
        "quick": quick,
        "results": [asdict(row) for row in rows],
        "exponents": exponents,
        "machine": machine(),
    }


def measure_light_cost(varied: str, value: float, *, repeats: int) -> LightCostRow:
    """One row.

    Args:
        varied: One of `SWEEPS`.
        value: Its value.
        repeats: Images that are timed.
    """
    size = DEFAULT | {varied: value}
    wall = round(size["cell_mm"] / 4, 4)
    scene = load_scene(
        "rest",
        [f"design.cell_mm={size['cell_mm']}", f"design.wall_mm={wall}", "design.lattice.spacing_mm=1.0",
         f"rig.camera.columns={size['columns']:.0f}", f"rig.camera.rows={size['columns'] * 4 / 3:.0f}",
         f"render.samples={size['samples']:.0f}", f"render.particles={size['particles']:.0f}",
         "render.anchor_samples=0"],
    )  # fmt: skip
    sensor = Sensor.for_scene(scene)
    view = sensor.view(UNTOUCHED, sensor.rest)
    world, elastomer = sensor.renderer.world(view), sensor.elastomer
    sensor.renderer.plain_radiance(view)
    updates, images = [], []
    for _ in range(repeats):
        start = time.perf_counter()
        world.update(body=elastomer.body.vertices, infill=elastomer.infill.vertices if elastomer.infill else None)
        middle = time.perf_counter()
        sensor.renderer.plain_radiance(view)
        updates.append(middle - start)
        images.append(time.perf_counter() - middle)
    infill = elastomer.infill
    return LightCostRow(
        varied=varied,
        cells=elastomer.grid.cell_count if elastomer.grid is not None else 0,
        triangles=len(elastomer.body.faces) + (len(infill.faces) if infill is not None else 0),
        seconds_update=float(np.median(updates)),
        seconds_image=float(np.median(images)),
        cell_mm=float(size["cell_mm"]),
        columns=int(size["columns"]),
        samples=int(size["samples"]),
        particles=int(size["particles"]),
    )


def _exponent(varied: str, rows: list[LightCostRow]) -> float:
    """Of the power law between the work and the seconds of one image."""
    work = [row.cells if varied == "cell_mm" else getattr(row, varied) for row in rows]
    seconds = [row.seconds_update + row.seconds_image for row in rows]
    return float(np.polyfit(np.log(work), np.log(seconds), 1)[0])
