"""Which physics do the verdicts rest on? The episodes of a suite with one part of it taken away at a time.

    python benchmarks/ablations.py --cache TAKES --out docs                  # about 40 CPU minutes, then seconds
    python benchmarks/ablations.py --cache TAKES --out docs --takes 2 --only deformation

Films the dark episodes of the small suite in small images (120 x 160, a quarter of the default's particles), once for
the full physics and once for each ablation, on the same deformations. What is filmed stays in the cache, so that a run
that is cut off goes on. Writes `ablations.json`, `ablations-table.txt` and `ablations.png`. Taking away temporal
fusion needs no filming.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from laboratory.ablation.films import ABLATIONS, NOTHING, film_ablated
from laboratory.ablation.scores import (
    MEASURED,
    ablated_footage,
    compare_scores,
    score_ablation,
    without_fusion,
)
from laboratory.markdown import markdown_table
from laboratory.operating_point.reading import scaled
from matplotlib.figure import Figure

from magicsim.detectors import load_profile
from magicsim.evaluation.footage import Footage
from magicsim.evaluation.suite import load_suite
from magicsim.evaluation.take import list_cases

COLUMNS, ROWS, FULL = 120, 160, 240
QUALITY = (
    "render.samples=2", "render.particles=20000", "render.anchor_samples=12", "render.anchor_particles=300000",
)  # fmt: skip
FUSION = "temporal_fusion"


def measure(cache: Path, *, takes: int | None, names: Sequence[str]) -> dict[str, Any]:
    """Films what is missing and scores all."""
    size = (f"rig.camera.columns={COLUMNS}", f"rig.camera.rows={ROWS}")
    suite = load_suite("small", [*size, *QUALITY])
    profile = scaled(load_profile("calibrated"), columns=COLUMNS, full=FULL)
    cases = [each for each in list_cases(suite) if each.light == suite.lights[0].name][:takes]
    filmed: dict[str, list[Footage]] = {name: [] for name in names}
    refused: dict[str, str] = {}
    for number, case in enumerate(cases, 1):
        for name, take in film_ablated(case.scene, names, cache).items():
            if isinstance(take, str):
                refused[name] = take
            else:
                filmed[name].append(ablated_footage(case, take, suite))
        print(f"{number} of {len(cases)} takes", flush=True)
    scores = {
        name: {"refused": refused[name]} if name in refused else score_ablation(films, profile, suite)
        for name, films in filmed.items()
    }
    scores[FUSION] = score_ablation(filmed[NOTHING], without_fusion(profile), suite)
    says = {name: ABLATIONS[name].says for name in names} | {FUSION: "one frame is the whole reference"}
    return {
        "kind": "ablations", "suite": "small", "takes": len(cases), "image": [COLUMNS, ROWS], "profile": "calibrated",
        "says": says, "scores": scores, "falls": compare_scores(scores, NOTHING),
    }  # fmt: skip


def plot(data: dict[str, Any], target: Path) -> None:
    """Measures with their intervals, one row an ablation; a refusal is named."""
    shown = MEASURED[:4]
    names = list(data["scores"])
    figure = Figure(figsize=(13, 0.5 * len(names) + 1.6), layout="constrained")
    for panel, name in zip(figure.subplots(1, len(shown), sharey=True), shown, strict=True):
        for place, ablation in enumerate(names):
            score = data["scores"][ablation]
            if "refused" in score or score["measures"][name]["value"] is None:
                panel.text(0.5, place, "no image to judge", va="center", ha="center", fontsize=8, color="#777777")
                continue
            one = score["measures"][name]
            panel.plot(one["value"], place, "o", color="#0072b2")
            if one["low"] is not None:
                panel.plot([one["low"], one["high"]], [place, place], color="#0072b2")
        panel.set(title=name.replace("_", " "), xlim=(0, 1.03), yticks=range(len(names)))
        panel.set_yticklabels([f"without {each}" if each != NOTHING else "full physics" for each in names])
        panel.grid(axis="x", color="#e4e4e4")
        panel.title.set_fontsize(9)
    panel.invert_yaxis()
    figure.savefig(target, dpi=90, metadata={"Software": None})


def table(data: dict[str, Any]) -> str:
    """Measures of every ablation with their intervals, in Markdown."""
    names = {"full physics": NOTHING} | {f"without {each}": each for each in data["scores"] if each != NOTHING}
    rows = []
    for title, name in names.items():
        score = data["scores"][name]
        cells = [score["refused"]] if "refused" in score else [interval(score["measures"][one]) for one in MEASURED]
        rows.append([title.replace("_", " "), *cells, *[""] * (len(MEASURED) - len(cells))])
    return markdown_table(["", *(each.replace("_", " ") for each in MEASURED)], rows) + "\n"


def interval(measure: dict[str, Any]) -> str:
    """A measure with its interval."""
    if measure["value"] is None:
        return "-"
    value = f"{measure['value']:.2f}"
    return value if measure["low"] is None else f"{value} ({measure['low']:.2f} to {measure['high']:.2f})"


def main() -> None:
    """Measures and writes JSON and plot."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path("docs"))
    parser.add_argument("--takes", type=int)
    parser.add_argument("--only", action="append", default=[])
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    names = [NOTHING, *(given.only or [each for each in ABLATIONS if each != NOTHING])]
    data = measure(given.cache, takes=given.takes, names=names)
    (given.out / "ablations.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    (given.out / "ablations-table.txt").write_text(table(data), encoding="utf-8")
    plot(data, given.out / "ablations.png")
    for name, falls in data["falls"].items():
        print(name, {key: round(value, 3) for key, value in falls.items()})


if __name__ == "__main__":
    main()
