"""Which values of the assumed constants bring the simulated sensor to the published figures of E, C and S?

    python benchmarks/operating_point.py search SEARCH.jsonl --steps 48 --first 24     # CPU minutes a step: two
    python benchmarks/operating_point.py search SEARCH.jsonl --steps 64 --aim verdicts # goes on for another aim
    python benchmarks/operating_point.py check SEARCH.jsonl                            # best ones with less noise
    python benchmarks/operating_point.py report SEARCH.jsonl --out docs
    python benchmarks/operating_point.py sensor docs/operating-point.json --out SENSOR # its rig, design and profile

`search` films one choice of the optical constants a step and reads it through many cameras; a run
that is cut off goes on where it stopped. The first steps cover the ranges evenly (Sobol), the rest move the best: those
that are nearest to the published figures, or those for which the published thresholds give the right verdicts.
`check` renders the default, the best of the ensemble, the nearest to right verdicts and the sensor that meets most
targets with more samples, and leaves out each mechanism of the last. `report` writes `operating-point.json`: targets,
ensemble, distance by quantity, how far the ensemble narrows each range, which targets are met together; and its tables.
`sensor` writes the one nearest to right verdicts as TOML files.
"""

import argparse
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from laboratory.operating_point.counts import counts
from laboratory.operating_point.ensemble import summarise
from laboratory.operating_point.filming import QUALITY, film_states, search_scene
from laboratory.operating_point.front import met
from laboratory.operating_point.reading import read_states, short_of
from laboratory.operating_point.search import (
    CAMERA,
    CAMERA_NAMES,
    EFFECT_NAMES,
    OPTICAL,
    OPTICAL_NAMES,
    Candidate,
    as_row,
    camera_values,
    candidate,
    grid_reading,
    left_out,
    optical_fields,
    search_step,
    sensor_scene,
    value_at,
)
from laboratory.operating_point.tables import tables
from laboratory.operating_point.targets import distances, total_distance

from magicsim.conventions import IMAGE_COLUMNS
from magicsim.detectors import load_profile
from magicsim.errors import MagicsimError
from magicsim.fit.constants import CONSTANTS, value_of
from magicsim.scenes.scene import load_scene

COLUMNS, ROWS = IMAGE_COLUMNS, 320
CAMERAS = 32
GOOD = 5
"""Best steps that the later ones are drawn around."""
AIMS: Mapping[str, Callable[[Candidate], float]] = {
    "figures": lambda each: each.distance,
    "verdicts": lambda each: short_of(each.reading, load_profile("published")),
}
"""What is to be small."""
CAREFUL = (
    "render.samples=4", "render.particles=60000", "render.anchor_samples=20", "render.anchor_particles=600000",
)  # fmt: skip


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Steps that are done, without a last line that was cut off."""
    if not path.is_file():
        return []
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            continue
    return rows


def best_of(rows: Sequence[dict[str, Any]], count: int, aim: str = "figures") -> list[Candidate]:
    """The best candidate of each of the best steps."""
    read = [[Candidate.read_back(each) for each in row["candidates"]] for row in rows if row["candidates"]]
    return sorted((min(each, key=AIMS[aim]) for each in read), key=AIMS[aim])[:count]


def widest(rows: Sequence[dict[str, Any]]) -> Candidate:
    """The candidate that meets most targets together, the nearest of several."""
    every = [Candidate.read_back(each) for row in rows for each in row["candidates"]]
    return max(every, key=lambda each: (len(met(each.reading.quantities)), -each.distance))


def search(path: Path, *, steps: int, first: int, minutes: float, seed: int, aim: str) -> None:
    """Adds steps to the file until there are enough, or time is up."""
    scene = search_scene(COLUMNS, ROWS)
    profile = load_profile("published")
    rows, end = read_rows(path), time.monotonic() + 60 * minutes
    if rows:
        path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    for index in range(len(rows), steps):
        if time.monotonic() > end:
            break
        start, cpu = time.monotonic(), time.process_time()
        row: dict[str, Any] = {"index": index, "seed": seed, "first": first, "aim": aim, "candidates": []}
        try:
            found = search_step(
                scene,
                profile,
                best_of(rows, GOOD, aim),
                aim=AIMS[aim],
                index=index,
                first=first,
                cameras=CAMERAS,
                seed=seed,
            )
            row["candidates"] = as_row(found)
        except MagicsimError as error:
            row["refused"] = str(error)
        row["cpu_seconds"] = round(time.process_time() - cpu, 2)
        rows.append(row)
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        best = min((each["candidates"][0]["distance"] for each in rows if each["candidates"]), default=np.nan)
        print(f"step {index}: {time.monotonic() - start:.0f} s, best distance {best:.3f}", flush=True)


def checked_file(path: Path) -> Path:
    """Where `check` keeps what it rendered, beside the search."""
    return path.with_suffix(".check.json")


def default_reading(quality: tuple[str, ...]) -> dict[str, Any]:
    """The default sensor."""
    scene = search_scene(COLUMNS, ROWS, quality)
    reading = read_states(
        film_states(scene, {}), scene.rig.camera, ambient=float(np.mean(scene.rig.ambient)), flashlight=1.0,
        crosstalk=0.0, profile=load_profile("published"),
    )  # fmt: skip
    return asdict(reading) | {"distance": total_distance(reading.quantities)}


def check(path: Path, *, members: int) -> None:
    """Default as in the search and with less noise, and the best of the ensemble with less noise."""
    target = checked_file(path)
    found: dict[str, Any] = json.loads(target.read_text(encoding="utf-8")) if target.is_file() else {}
    for name, quality in (("default", QUALITY), ("default_careful", CAREFUL)):
        if name not in found:
            found[name] = default_reading(quality)
            target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    scene, profile = search_scene(COLUMNS, ROWS, CAREFUL), load_profile("published")

    def with_less_noise(each: Candidate) -> dict[str, Any]:
        careful = candidate(film_states(scene, optical_fields(each.optical)), scene, each.optical, each.camera, profile)
        return {"searched": asdict(each), "careful": None if careful is None else asdict(careful)}

    rows = read_rows(path)
    found["widest"] = with_less_noise(widest(rows))
    target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    found["verdicts"] = with_less_noise(best_of(rows, 1, "verdicts")[0])
    target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    found["members"] = []
    for each in best_of(rows, members):
        found["members"].append(with_less_noise(each))
        target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    found["without"] = left_out(widest(rows), search_scene(COLUMNS, ROWS), profile)
    target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(json.dumps({name: distances(found[name]["quantities"]) for name in ("default", "default_careful")}))


def named_values(sensor: Mapping[str, Any]) -> dict[str, float | str]:
    """Every constant of a sensor by its name."""
    names, shares = (*OPTICAL_NAMES, *CAMERA_NAMES), (*sensor["optical"], *sensor["camera"])
    return {name: value_at(name, share) for name, share in zip(names, shares, strict=True)}


def report(path: Path, out: Path, name: str) -> None:
    """Writes the summary of a search, and its tables."""
    rows = read_rows(path)
    summary = summarise(rows)
    scene = search_scene(COLUMNS, ROWS)
    summary["default"] = {name: value_of(scene, CONSTANTS[name].path) for name in (*OPTICAL, *CAMERA)}
    best = best_of(rows, 1)[0]
    summary["best"]["fields"] = optical_fields(best.optical) | camera_values(best.camera)
    shares = zip(CAMERA_NAMES, best.camera, strict=True)
    summary["best"]["effects"] = {each: value_at(each, share) for each, share in shares if each in EFFECT_NAMES}
    summary["best"]["grid_reading"] = grid_reading(best.camera)
    checked = checked_file(path)
    if checked.is_file():
        summary["check"] = json.loads(checked.read_text(encoding="utf-8"))
    if "verdicts" in summary.get("check", {}):
        summary["check"]["verdicts"]["constants"] = named_values(summary["check"]["verdicts"]["searched"])
    summary["counts"] = counts(rows, summary.get("check", {}).get("default", {}).get("quantities"))
    (out / f"{name}.json").write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")
    (out / f"{name}-tables.txt").write_text(tables(summary), encoding="utf-8")
    print(json.dumps(summary["distance"], indent=1))


def write_sensor(summary: Path, out: Path) -> None:
    """Writes rig, design and profile of the sensor nearest to right verdicts, and says the rest."""
    found = json.loads(summary.read_text(encoding="utf-8"))["check"]["verdicts"]["searched"]
    scene = sensor_scene(load_scene("demo"), found["optical"], found["camera"])
    polarity, similarity = grid_reading(found["camera"])
    profile = replace(load_profile("published"), polarity=polarity, similarity=similarity)
    for name, values in (
        ("rig", scene.rig.model_dump(mode="json", exclude_none=True)),
        ("design", scene.design.model_dump(mode="json", exclude_none=True)),
        ("profile", {"schema_version": 1} | asdict(profile)),
    ):
        (out / f"{name}.toml").write_text(tomli_w.dumps(values), encoding="utf-8")
    print(f"--set rig={out}/rig.toml --set design={out}/design.toml --set contact.coupling={scene.contact.coupling}")


def main() -> None:
    """Runs one stage."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage", choices=("search", "check", "report", "sensor"))
    parser.add_argument("rows", type=Path)
    parser.add_argument("--steps", type=int, default=48)
    parser.add_argument("--first", type=int, default=24)
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--aim", choices=AIMS, default="figures")
    parser.add_argument("--members", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("docs"))
    parser.add_argument("--name", default="operating-point", help="of the report's files")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    if given.stage == "search":
        search(given.rows, steps=given.steps, first=given.first, minutes=given.minutes, seed=given.seed, aim=given.aim)
    elif given.stage == "check":
        check(given.rows, members=given.members)
    elif given.stage == "report":
        report(given.rows, given.out, given.name)
    else:
        write_sensor(given.rows, given.out)


if __name__ == "__main__":
    main()
