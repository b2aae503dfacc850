"""Forces and areas of contact at the default settings, beside lattices that are much finer.

    python benchmarks/default_lattice.py [--only punch] [--out FILE.json]

Each object is pressed into the default design, and on by 0.05 mm: as it ships, without planes at the object's edges
(`lattice.edge_nodes=0`, where it has edges), and as the reference on a quarter of the block: below flat faces with
nodes half as far apart everywhere and at the edges, below balls with five to seven nodes across half the contact, but
not closer than 0.07 mm. Processor seconds of both steps are beside them; only their ratios say anything.
"""

import argparse
import json
import math
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.spot import QUARTERS, central_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice, lattice_on
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

MORE_MM, FINE_SCALE = 0.05, 0.5
"""What is pressed on, and the reference's spacing across edges in units of that of the default."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One object, pressed."""

    line: str
    depth_mm: float = 0.6
    fine_mm: float = 0.45
    """Spacing of the reference [mm]."""

    @property
    def is_round(self) -> bool:
        """Whether the object has no edges."""
        return self.line.startswith("sphere")


BALLS = {
    f"ball of {radius:g} mm, {depth:g} mm deep": Case(
        line=f"sphere:radius_mm={radius:g}", depth_mm=depth, fine_mm=max(0.13 * math.sqrt(radius * depth), 0.07)
    )
    for radius in (2, 4, 8)
    for depth in (0.02, 0.1, 0.3, 1)
}
CASES = {
    "punch": Case(line="punch:radius_mm=3"),
    "box": Case(line="box:size_mm=4"),
    "pen": Case(line="cylinder:radius_mm=5,length_mm=60,edge_radius_mm=0.5,axis=x"),
    "plug": Case(line="box:size_mm=12x4.5x12,edge_radius_mm=0.3"),
    **BALLS,
}


def lattice_of(case: Case, kind: str) -> Lattice:
    """The default's lattice, the one without edges, or the reference."""
    without = ["lattice.edge_nodes=0"] if kind == "without edges" else []
    design = load_preset(ElastomerDesign, "design", "mini-magictac", without)
    zone = contact_zone([place_object(parse_object(case.line), gap_mm=-case.depth_mm - MORE_MM)], design)
    if zone is None:
        raise ValueError(f"{case.line} does not touch")
    if kind != "reference":
        return build_lattice(design, zone=zone)
    coarse = central_lattice(design, zone, spacing_mm=case.fine_mm, is_quarter=True)
    if zone.edges is None:
        return coarse
    x, y, z = coarse.planes_mm
    planes = (
        zone.edges.split(x, 0, scale=FINE_SCALE), zone.edges.split(y, 1, scale=FINE_SCALE),
        zone.edges.split_depth(z, scale=FINE_SCALE),
    )  # fmt: skip
    return replace(lattice_on(planes, design), zone=zone, is_mirrored=True)


def pressed(case: Case, kind: str) -> dict[str, Any]:
    """Force and area at the first depth, and processor seconds of both steps."""
    lattice, thing = lattice_of(case, kind), parse_object(case.line)
    share = QUARTERS if lattice.is_mirrored else 1
    solver, state, seconds, found = (
        ContactSolver(lattice, point_spacing_mm=point_spacing_mm(thing.shape())),
        None,
        [],
        [],
    )
    for depth in (case.depth_mm, case.depth_mm + MORE_MM)[: 1 if kind == "reference" else None]:
        start = time.process_time()
        state = solver.solve(place_object(thing, gap_mm=-depth), state)
        seconds.append(round(time.process_time() - start, 2))
        found.append((share * float(state.force_n[2]), share * state.contact_area_mm2))
    return {
        "force_n": round(found[0][0], 4),
        "area_mm2": round(found[0][1], 2),
        "unknowns": share * 3 * lattice.free_nodes,
        "seconds": seconds,
    }


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", choices=list(CASES))
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    compile_kernels()
    rows: dict[str, Any] = {}
    for name, case in CASES.items():
        if chosen.only not in (None, name):
            continue
        kinds = ("default",) if case.is_round else ("without edges", "default")
        row: dict[str, Any] = {"depth_mm": case.depth_mm}
        row |= {kind: pressed(case, kind) for kind in (*kinds, "reference")}
        best = row["reference"]
        for kind in kinds:
            for key in ("force_n", "area_mm2"):
                row[kind][f"{key}_off"] = round(row[kind][key] / best[key] - 1, 4)
        rows[name] = row
    text = json.dumps({"objects": rows}, indent=1)
    print(text)
    if chosen.out is not None:
        chosen.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
