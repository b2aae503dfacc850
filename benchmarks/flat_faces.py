"""Forces and areas of flat faces and edges at the default settings, beside lattices much finer at the edges.

    python benchmarks/flat_faces.py [--only punch] [--out FILE.json]

Each object is pressed into the default design by 0.6 and on by 0.05 mm: as it ships, without planes at the object's
edges (`lattice.edge_nodes=0`), and as the reference on a quarter of the block with nodes half as far apart
everywhere and at the edges. Processor seconds of both steps are beside them; only their ratios say
anything.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.central import QUARTERS, central_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice, lattice_on
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

OBJECTS = {
    "punch": "punch:radius_mm=3",
    "box": "box:size_mm=4",
    "pen": "cylinder:radius_mm=5,length_mm=60,edge_radius_mm=0.5,axis=x",
    "plug": "box:size_mm=12x4.5x12,edge_radius_mm=0.3",
}
DEPTHS_MM = (0.6, 0.65)
FINE_MM, FINE_SCALE = 0.45, 0.5
"""Spacing of the reference, and its spacing across edges in units of that of the default."""


def lattice_of(line: str, kind: str) -> Lattice:
    """The default's lattice, the one without edges, or the reference."""
    without = ["lattice.edge_nodes=0"] if kind == "without edges" else []
    design = load_preset(ElastomerDesign, "design", "mini-magictac", without)
    zone = contact_zone([place_object(parse_object(line), gap_mm=-max(DEPTHS_MM))], design)
    if zone is None:
        raise ValueError(f"{line} does not touch")
    if kind != "reference":
        return build_lattice(design, zone=zone)
    coarse = central_lattice(design, zone, spacing_mm=FINE_MM, is_quarter=True)
    if zone.edges is None:
        return coarse
    x, y, z = coarse.planes_mm
    planes = (
        zone.edges.split(x, 0, scale=FINE_SCALE), zone.edges.split(y, 1, scale=FINE_SCALE),
        zone.edges.split_depth(z, scale=FINE_SCALE),
    )  # fmt: skip
    return replace(lattice_on(planes, design), zone=zone, is_mirrored=True)


def pressed(line: str, kind: str) -> dict[str, Any]:
    """Force and area at the first depth, and processor seconds of both steps."""
    lattice, thing = lattice_of(line, kind), parse_object(line)
    share = QUARTERS if lattice.is_mirrored else 1
    solver, state, seconds, found = (
        ContactSolver(lattice, point_spacing_mm=point_spacing_mm(thing.shape())),
        None,
        [],
        [],
    )
    for depth in DEPTHS_MM[: 1 if kind == "reference" else None]:
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
    parser.add_argument("--only", choices=sorted(OBJECTS))
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    compile_kernels()
    rows: dict[str, Any] = {}
    for name, line in OBJECTS.items():
        if chosen.only not in (None, name):
            continue
        row = {kind: pressed(line, kind) for kind in ("without edges", "default", "reference")}
        best = row["reference"]
        for kind in ("without edges", "default"):
            for key in ("force_n", "area_mm2"):
                row[kind][f"{key}_off"] = round(row[kind][key] / best[key] - 1, 4)
        rows[name] = row
    text = json.dumps({"depth_mm": DEPTHS_MM[0], "objects": rows}, indent=1)
    print(text)
    if chosen.out is not None:
        chosen.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
