"""Random objects, places and depths: does a press say contact where geometry says it, and is nothing inside the block?

    python benchmarks/overlap.py --count 2000 --seed 0 [--unchecked] [--out FILE.json] [--rows FILE.jsonl]

Every object is pressed into a small plain block. Judged apart from the solver, with points on all triangles of the
object: an object that reaches into the undeformed block by more than the tolerance is felt or refused, one that does
not reach it leaves no force, and after every accepted press no point of it lies inside the deformed block, whose
closed surface is asked for its winding number. Prints one JSON object of counts; what is silently wrong is listed.
A press that takes more than `LONGEST_S` of the processor counts as no answer. `--rows` keeps every press as a line; a
run with the same file goes on where the last one stopped. `--unchecked` leaves out the solver's own check, to count
what it finds and what it costs.
"""

import argparse
import json
import signal
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import igl
import numpy as np
import numpy.typing as npt
import trimesh

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import ContactFace, face_weights, point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.overlap import EDGE_SHARE, UNSEEN_MM, overlap_fault
from magicsim.deform.solve import path
from magicsim.errors import MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object

Array = npt.NDArray[np.float64]
DESIGN = ("footprint_mm=[6,6]", "core_mm=3.0", "lattice.cells_across=0")
SPACINGS_MM = (0.5, 1.0)
SIDE_MM, HEIGHT_MM = 6.0, 4.0
DEPTHS_MM = (-0.3, 1.0)
NORMAL_MM = 0.2
"""Smallest feature of an object of normal size."""
SLACK_MM = 0.02
"""By which points between an object's vertices may lie deeper than these."""
LONGEST_S = 6
"""A press that takes more of the processor is counted as no answer: what is asked for here is what is accepted."""
SUBDIVISIONS = 8
"""Parts of a facet's edge on the closed surface of the block."""
RIGHT, REFUSED, UNANSWERED, WRONG = "right", "refused", "no answer", "silently wrong"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One press."""

    thing: str
    spacing_mm: float
    place_mm: tuple[float, float]
    depth_mm: float
    feature_mm: float
    overlap_mm: float
    """Of the undeformed object and block."""
    outcome: str
    reason: str
    seconds: float


def drawn_object(random: np.random.Generator, folder: Path) -> str:
    """The line of an object of any kind, its sizes over two decades, upright or tilted."""

    def size(low: float, high: float) -> float:
        return float(f"{np.exp(random.uniform(np.log(low), np.log(high))):.3g}")

    radius, small = size(0.03, 4.0), size(0.03, 0.6)
    edge = 0.2 * radius if radius > 0.06 else 0.011
    kinds = {
        "sphere": f"radius_mm={radius}",
        "cylinder": f"radius_mm={radius},length_mm={size(0.5, 12)},edge_radius_mm={min(edge, 0.1):.3g},axis=x",
        "punch": f"radius_mm={radius},edge_radius_mm={min(edge, 0.1):.3g}",
        "box": f"size_mm={radius}x{size(0.1, 6)}x{size(0.5, 8)},edge_radius_mm=0.011",
        "domed_cylinder": f"radius_mm={radius},edge_radius_mm={min(edge, 0.1):.3g}",
        "cone": f"half_angle_deg={random.uniform(5, 80):.0f},length_mm={size(1, 4)}",
        "dots": f"radius_mm={small},spacing_mm={2.05 * small + size(0.02, 1):.3g},size_mm=4",
        "lines": f"width_mm={small},spacing_mm={1.02 * small + size(0.02, 1):.3g},size_mm=4",
        "spanner": "jaw_mm=10",
        "screwdriver": f"radius_mm={size(2, 15)}",
        "scissors": f"tube_radius_mm={size(0.3, 3)}",
        "banana": f"radius_mm={size(3, 15)}",
        "mesh": f"path={folder / f'spike-{random.integers(8)}.stl'}",
    }
    kind = str(random.choice(list(kinds)))
    tilt = f",roll_deg={random.uniform(-40, 40):.1f},pitch_deg={random.uniform(-40, 40):.1f}"
    return f"{kind}:{kinds[kind]}" + (tilt if random.random() < 0.4 else "")


def spiked_plates(folder: Path) -> None:
    """Eight plates with one spike each, as mesh files."""
    for number in range(8):
        height, width = 0.2 + 0.15 * number, 0.06 + 0.05 * (number % 4)
        spike = trimesh.creation.cone(width, height + 0.1).apply_translation([0.3, 0.1, 0.4])
        plate = trimesh.creation.box((2.0, 2.0, 1.0))
        trimesh.boolean.union([plate, spike], engine="manifold").export(folder / f"spike-{number}.stl")


def surface_samples(indenter: Indenter, random: np.random.Generator) -> Array:
    """Vertices and random points of all triangles near the block, in the sensor's frame, shape (points, 3) [mm]."""
    mesh = indenter.shape.mesh()
    vertices = indenter.pose.to_sensor(mesh.vertices)
    triangles = vertices[mesh.faces]
    triangles = triangles[triangles[:, :, 2].max(1) > -1.0]
    weights = random.dirichlet((1.0, 1.0, 1.0), (len(triangles), 2))
    return np.concatenate([vertices, np.einsum("tkc,tci->tki", weights, triangles).reshape(-1, 3)])


def undeformed_overlap_mm(points: Array) -> float:
    """Longest way that a point of the object needs to leave the undeformed block; 0 where none is inside [mm]."""
    ways = np.concatenate([points[:, 2:], SIDE_MM / 2 - np.abs(points[:, :2])], axis=1)
    return max(0.0, float(ways.min(axis=1).max()))


def depths_inside(lattice: Lattice, state: Deformation, points: Array) -> tuple[Array, Array]:
    """Distances to the nearest face or side of the points inside the deformed block, and these points."""
    axes = [
        np.interp(np.linspace(0, len(planes) - 1, SUBDIVISIONS * (len(planes) - 1) + 1), np.arange(len(planes)), planes)
        for planes in lattice.planes_mm[:2]
    ]
    x, y = np.meshgrid(*axes)
    nodes = lattice.nodes_mm + state.displacements_mm
    face = face_weights(lattice, np.stack([x.ravel(), y.ravel()], axis=1)) @ nodes
    rows, columns = x.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    sheet = np.concatenate([np.stack([a, d, c], 1), np.stack([c, b, a], 1)])
    rim = np.concatenate([number[0], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])
    # the sides straight up from the rim, which is what contact leaves alone, closed by a fan far above
    top = face[rim] * [1, 1, 0] + [0, 0, HEIGHT_MM]
    vertices = np.concatenate([face, top, [[0.0, 0.0, HEIGHT_MM]]])
    upper, following = len(face) + np.arange(len(rim)), np.roll(rim, -1)
    above = np.roll(upper, -1)
    apex = np.full(len(rim), len(vertices) - 1)
    closed = np.concatenate(
        [
            sheet,
            np.stack([rim, following, above], 1),
            np.stack([above, upper, rim], 1),
            np.stack([upper, above, apex], 1),
        ]
    )
    near = points[(points[:, 2] > face[:, 2].min()) & (np.abs(points[:, :2]).max(1) < SIDE_MM)]
    if len(near) == 0:
        return np.empty(0), near
    winding = igl.fast_winding_number(vertices, closed.astype(np.int64), np.ascontiguousarray(near))
    near = near[np.abs(winding) > 0.5]
    if len(near) == 0:
        return np.empty(0), near
    sides = closed[: -len(rim)].astype(np.int64)  # without the fan
    squared, _, _ = igl.point_mesh_squared_distance(np.ascontiguousarray(near), vertices, sides)
    return np.sqrt(squared), near


def judged(lattice: Lattice, state: Deformation, indenter: Indenter, points: Array) -> tuple[str, str]:
    """Outcome of an accepted press, and why."""
    feature = indenter.shape.feature_mm
    least = min(UNSEEN_MM, feature)
    overlap, is_felt = undeformed_overlap_mm(points), bool(np.any(state.force_n))
    if overlap == 0 and is_felt:
        return WRONG, "a force without an overlap"
    if overlap > least + SLACK_MM and not is_felt:
        return WRONG, f"no force at an overlap of {overlap:.3f} mm"
    depth, _ = depths_inside(lattice, state, points)
    spacing = max(float(np.diff(planes).max()) for planes in lattice.planes_mm[:2])
    limit = max(least, EDGE_SHARE * spacing if is_felt else 0.0) + SLACK_MM
    if depth.max(initial=0.0) > limit:
        return WRONG, f"{depth.max():.3f} mm inside the deformed block"
    return RIGHT, "felt" if is_felt else "apart" if overlap == 0 else "an overlap within the tolerance"


def run(random: np.random.Generator, folder: Path) -> Row:
    """One random press."""
    line, spacing = drawn_object(random, folder), float(random.choice(SPACINGS_MM))
    place = (float(random.uniform(-4, 4)), float(random.uniform(-4, 4)))
    depth = float(random.uniform(*DEPTHS_MM))
    start = time.perf_counter()

    def row(outcome: str, reason: str, *, feature: float = 0.0, overlap: float = 0.0) -> Row:
        return Row(
            thing=line.replace(str(folder), ""), spacing_mm=spacing, place_mm=place, depth_mm=depth,
            feature_mm=feature, overlap_mm=overlap, outcome=outcome, reason=reason,
            seconds=time.perf_counter() - start,
        )  # fmt: skip

    try:
        thing = parse_object(line)
    except MagicsimError as error:
        return row("not an object", str(error)[:80])
    indenter = place_object(thing, gap_mm=-depth, x_mm=place[0], y_mm=place[1])
    feature, points = indenter.shape.feature_mm, surface_samples(indenter, random)
    overlap = undeformed_overlap_mm(points)
    design = load_preset(ElastomerDesign, "design", "uniform-block", [*DESIGN, f"lattice.spacing_mm={spacing}"])
    lattice = build_lattice(design, zone=contact_zone([indenter], design))
    try:
        with time_limit():
            solver = path.ContactSolver(lattice, point_spacing_mm=point_spacing_mm(indenter.shape))
            state = solver.solve(indenter)
    except TimeoutError:
        return row(UNANSWERED, "", feature=feature, overlap=overlap)
    except MagicsimError as error:
        reasons = (
            "passed through",
            "no contact point near it",
            "would close above it",
            "around an edge or a tip",
            "valid equilibrium",
        )
        reason = next((each for each in reasons if each in str(error)), str(error))
        is_false = overlap == 0
        return row(WRONG if is_false else REFUSED, reason, feature=feature, overlap=overlap)
    outcome, reason = judged(lattice, state, indenter, points)
    return row(outcome, reason, feature=feature, overlap=overlap)


@contextmanager
def time_limit() -> Iterator[None]:
    """Raises TimeoutError after `LONGEST_S`."""

    def stop(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def summary(rows: list[Row], costs_ms: list[float]) -> dict[str, object]:
    """Counts of outcomes and reasons, of all and of objects of normal size, and what the check costs."""

    def counts(chosen: list[Row]) -> dict[str, object]:
        touching = [row for row in chosen if row.overlap_mm > 0]
        accepted = sum(row.outcome in (RIGHT, WRONG) for row in touching)
        return {
            "presses": len(chosen),
            "outcomes": dict(Counter(row.outcome for row in chosen)),
            "reasons": {f"{a}: {b}": n for (a, b), n in Counter((r.outcome, r.reason) for r in chosen).most_common(20)},
            "accepted_share_of_overlapping": round(accepted / max(1, len(touching)), 4),
        }

    real = [row for row in rows if row.outcome != "not an object"]
    return {
        "all": counts(real),
        "normal_size": counts([row for row in real if row.feature_mm >= NORMAL_MM]),
        "median_press_ms": round(1e3 * statistics.median(row.seconds for row in real), 1),
        "median_check_ms": round(statistics.median(costs_ms), 2) if costs_ms else None,
        "longest_check_ms": round(max(costs_ms), 1) if costs_ms else None,
        "wrong": [asdict(row) for row in real if row.outcome == WRONG],
    }


def kept_rows(path: Path | None) -> list[Row]:
    """Presses of an earlier run, in its order; a line that was cut off is dropped."""
    if path is None or not path.exists():
        return []
    lines = [line for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")]
    path.write_text("".join(lines))
    kept = [json.loads(line) for line in lines]
    return [Row(**(row | {"place_mm": tuple(row["place_mm"])})) for row in kept]


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--unchecked", action="store_true")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--rows", type=Path)
    chosen = parser.parse_args()
    compile_kernels()
    costs_ms: list[float] = []

    def timed(lattice: Lattice, face: ContactFace, state: Deformation, indenter: Indenter) -> str | None:
        start = time.perf_counter()
        found = overlap_fault(lattice, face, state, indenter)
        if indenter.top_mm() > 0:
            costs_ms.append(1e3 * (time.perf_counter() - start))
        return None if chosen.unchecked else found

    vars(path)["overlap_fault"] = timed
    rows = kept_rows(chosen.rows)
    with tempfile.TemporaryDirectory() as name:
        spiked_plates(Path(name))
        for number in range(len(rows), chosen.count):
            rows.append(run(np.random.default_rng([chosen.seed, number]), Path(name)))
            if chosen.rows is not None:
                with chosen.rows.open("a") as file:
                    file.write(json.dumps(asdict(rows[-1])) + "\n")
            if chosen.out is not None and (number + 1) % 50 == 0:
                chosen.out.write_text(json.dumps(summary(rows, costs_ms) | {"done": number + 1}, indent=1) + "\n")
    text = json.dumps(summary(rows, costs_ms) | {"seed": chosen.seed, "unchecked": chosen.unchecked}, indent=1)
    print(text)
    if chosen.out is not None:
        chosen.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
