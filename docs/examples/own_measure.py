"""A measure of your own: how much light material a design holds, for every design of a sweep.

python docs/examples/own_measure.py        # a line a design, at once
"""

from magicsim import load_sweep
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import resolve_grid
from magicsim.judge.measures import MeasureKind
from magicsim.sweep.designs import list_designs
from magicsim.sweep.measures import Measured

KIND = MeasureKind(
    title="Infill", unit="", digits=3, better=None, is_exact=True, meaning="Share of the block that is infill; exact."
)
"""What the table and the explorer say of it; in the package it is a row of `measures.csv`."""


def infill_share(design: ElastomerDesign) -> Measured:
    """Volume of all cells over that of the block, 0..1."""
    grid = resolve_grid(design)
    if grid is None:
        return Measured(value=0.0, low=0.0, high=0.0, note="no grid")
    width, length = design.footprint_mm
    x, y, z = grid.cell_mm.tolist()
    columns, rows, layers = grid.counts
    share = columns * rows * layers * x * y * z / (width * length * design.height_mm)
    return Measured(value=share, low=share, high=share)


def measured(name: str, settings: list[str]) -> list[tuple[dict[str, object], Measured]]:
    """Values that make each design of a sweep, and its measure."""
    designs = list_designs(load_sweep(name, settings))
    return [(dict(each.values), infill_share(each.sensor.design)) for each in designs]


if __name__ == "__main__":
    for values, found in measured("cell-skin", []):
        print(values, f"{KIND.title} {found.value:.{KIND.digits}f}")
