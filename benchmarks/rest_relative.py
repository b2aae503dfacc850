"""How the thresholds of `rest-relative` were chosen on simulated sensors of several types, and what it will find.

    python benchmarks/rest_relative.py film TAKES --count 2    # two takes of each type; goes on where it was stopped
    python benchmarks/rest_relative.py judge TAKES             # fits, judges and predicts from the takes that are there

Types, rooms, prints and objects are drawn (`laboratory.rest_relative.takes`); each take goes through several cameras,
and once more from nearer, where the same touch covers more of the picture. No real recording is used. `judge` writes
`docs/see-through.json` and, from it, `docs/see-through-tables.txt`.
"""

import argparse
import json
import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from laboratory.markdown import markdown_table
from laboratory.rest_relative.cameras import Recording, film, nearer
from laboratory.rest_relative.judging import MEASURES, Reading, falls, judge, judge_fixed, thresholds
from laboratory.rest_relative.takes import COATED, TYPES, draw_takes

from magicsim.evaluation.take import film_take, read_take, write_take
from magicsim.judge.measures import ends

CAMERAS, DRAWN = 3, 20
MIRRORS = ("mirror-dim", "mirror-bright")
"""Types like the sensor of the recordings that the prediction is for."""
RESAMPLES = 4000


def recordings(folder: Path) -> list[Recording]:
    """Every take that is there through every camera, and see-through ones from nearer too."""
    found = []
    for drawn in draw_takes(DRAWN):
        path = folder / f"{drawn.name}.npz"
        if path.is_file():
            films = [film(drawn, read_take(path), number) for number in range(CAMERAS)]
            found += [*films, *(nearer(each) for each in films[1:] if drawn.type not in (*COATED, "dots"))]
    return found


def summary(readings: Sequence[Reading]) -> dict[str, Any]:
    """Of each measure: mean over recordings, its interval by the bootstrap over them, and where nine of ten lie."""
    random, told = np.random.default_rng(0), {}
    for name in MEASURES:
        values = np.array([value for each in readings if (value := each.measures[name]) is not None])
        if not len(values):
            continue
        means = values[random.integers(len(values), size=(RESAMPLES, len(values)))].mean(1)
        told[name] = {
            "mean": round(float(values.mean()), 3),
            "interval": np.round(ends(means), 3).tolist(),
            "recordings": np.quantile(values, (0.05, 0.95)).round(3).tolist(),
        }
    return told


def found_by(films: Sequence[Recording]) -> dict[str, Any]:
    """All figures."""
    present = [name for name in TYPES if any(each.type == name for each in films)]
    seen = {name: [each for each in films if each.type == name] for name in present}
    curves = {each.name: falls(each) for each in films}
    by_type = {name: [curves[each.name] for each in group] for name, group in seen.items()}
    left_out = {name: thresholds({key: each for key, each in by_type.items() if key != name}) for name in present}
    no_mirror = thresholds({key: each for key, each in by_type.items() if key not in MIRRORS})
    found: dict[str, Any] = {
        "takes": {name: len({each.name.split("/")[0] for each in group}) for name, group in seen.items()},
        "recordings": {name: len(group) for name, group in seen.items()},
        "fall_left_out": left_out | {"both mirrors": no_mirror},
        "fall_all": thresholds(by_type),
        "types": {}, "touches": {}, "left_out": {},
    }  # fmt: skip
    for name, group in seen.items():
        found["types"][name] = summary([judge(each) for each in group])
        found["touches"][name] = summary([judge(each, with_own_touches=True) for each in group])
        found["left_out"][name] = summary([judge(each, fall=left_out[name]["fall"]) for each in group])
    mirrors = [each for name in MIRRORS for each in seen.get(name, [])]
    found["mirrors"] = {
        "rest-relative": summary([judge(each) for each in mirrors]),
        "rest-relative, own touches": summary([judge(each, with_own_touches=True) for each in mirrors]),
        "rest-relative, fitted without mirrors": summary([judge(each, fall=no_mirror["fall"]) for each in mirrors]),
        **{name: summary([judge_fixed(each, name) for each in mirrors]) for name in ("calibrated", "published")},
    }
    return found


def tables(found: dict[str, Any]) -> str:
    """Markdown of the page."""
    names = ("balanced", "touched", "clear", "near", "light")
    heads = [MEASURES[name] for name in names]
    rows = [[kind, *(_share(each.get(name)) for name in names)] for kind, each in found["types"].items()]
    others = [
        [kind, _share(found["left_out"][kind]["balanced"]), _share(found["touches"][kind].get("balanced")),
         f"{100 * found['fall_left_out'][kind]['fall']:.2g} %"]
        for kind in found["types"]
    ]  # fmt: skip
    profiles = [[name, *(_share(each.get(key)) for key in names)] for name, each in found["mirrors"].items()]
    return "\n\n".join(
        (
            markdown_table(["type", *heads], rows),
            markdown_table(["type", "balanced, fall fitted without this type", "balanced, own touches", "that fall"],
                           others),
            markdown_table(["mirror types, profile", *heads], profiles),
        )
    ) + "\n"  # fmt: skip


def _share(one: dict[str, Any] | None) -> str:
    if one is None:
        return "-"
    low, high = one["recordings"]
    return f"**{one['mean']:.2f}** ({low:.2f} to {high:.2f})"


def main() -> None:
    """Films, or judges what is filmed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("film", "judge"))
    parser.add_argument("takes", type=Path, help="folder of takes")
    parser.add_argument("--count", type=int, default=2, help="takes of each type to film")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    if arguments.what == "film":
        arguments.takes.mkdir(parents=True, exist_ok=True)
        for drawn in draw_takes(arguments.count):
            path = arguments.takes / f"{drawn.name}.npz"
            if not path.is_file():
                write_take(path, film_take(drawn.scene))
                logging.info("filmed %s", drawn.name)
        return
    found = found_by(recordings(arguments.takes))
    Path("docs/see-through.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    Path("docs/see-through-tables.txt").write_text(tables(found), encoding="utf-8")


if __name__ == "__main__":
    main()
