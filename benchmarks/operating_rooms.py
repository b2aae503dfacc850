"""The default sensor in four rooms through many cameras: which published figures are met together, and what each does.

    python benchmarks/operating_rooms.py --out docs --cameras 300     # CPU minutes: ten

Optics stay those of the default; rendered once a room are a large object's approach and touch, by the strips and by the
room apart. Exposure, tone curve, noise, crosstalk, strengths of room and flashlight, live exposure and the reading of S
are drawn (`benchmarks/operating_point.py` has their ranges and the targets). Told are the best camera of each room, the
best with one mechanism left out, and the pairs of targets that none of them meets together. Writes
operating-rooms.json and operating-rooms-tables.txt.
"""

import argparse
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from laboratory.markdown import markdown_table
from laboratory.operating_point.draws import first_points
from laboratory.operating_point.filming import FilmedStates, film_states, search_scene
from laboratory.operating_point.front import exclusive, met
from laboratory.operating_point.reading import read_states, scaled
from laboratory.operating_point.search import (
    CAMERA,
    CAMERA_NAMES,
    EFFECT_NAMES,
    camera_values,
    exposing,
    grid_reading,
)
from laboratory.operating_point.targets import TARGETS, total_distance

from magicsim.camera.settings import LiveExposure
from magicsim.detectors import DetectorProfile, load_profile
from magicsim.errors import FrameError, RenderError
from magicsim.fit.constants import CONSTANTS
from magicsim.scenes.rig import Camera

COLUMNS, ROWS, FULL = 120, 160, 240
OF_ROOM = {"office": "office", "window": "window", "bench": "bench", "even light": None}
SEED = 3
LEFT_OUT: Mapping[str, Mapping[str, Any]] = {
    "the room": {"ambient": 0.0},
    "crosstalk of the colours": {"crosstalk": 0.0},
    "noise beyond the default's": {"full_well": 250_000.0, "read_noise": 50.0},
    "a darker exposure than 90": {"exposure": 90.0},
    "the tone curve": {"gamma": 1.0},
    "live exposure": {"live": None},
    "another reading of S than dark, recall": {"reading": ("dark", "recall")},
}
"""Mechanisms, and the value of what has them not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """One camera in one room."""

    room: str
    values: dict[str, Any]
    distance: float
    quantities: dict[str, float]


def drawn(point: list[float]) -> dict[str, Any]:
    """Values of a camera at shares of its ranges."""
    return camera_values(point) | {"live": exposing(point), "reading": grid_reading(point)}


def read(states: FilmedStates, camera: Camera, values: Mapping[str, Any], profile: DetectorProfile) -> Any:  # noqa: ANN401
    """Quantities through one camera; None where it shows no grid."""
    changes = {CONSTANTS[name].path.rpartition(".")[2]: values[name] for name in CAMERA}
    polarity, similarity = values["reading"]
    try:
        return read_states(
            states, camera.model_copy(update=changes | {"live": values["live"]}), ambient=values["ambient"],
            flashlight=values["flashlight"], crosstalk=values["crosstalk"],
            profile=replace(profile, polarity=polarity, similarity=similarity),
        ).quantities  # fmt: skip
    except (FrameError, RenderError):
        return None


def plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values as JSON has them."""
    live: LiveExposure | None = values["live"]
    kind = "locked" if live is None else "live, balance too" if live.white_balance else "live"
    return dict(values) | {"live": kind, "reading": " ".join(values["reading"])}


def tables(best: list[Found], without: dict[str, float | None], excluded: list[tuple[str, str]], count: int) -> str:
    """The page's tables."""
    head = ["published", "target", *(f"{each.room}" for each in best)]
    rows = [
        [target.says, f"{target.low:g} to {target.high:g}", *(_shown(name, each.quantities[name]) for each in best)]
        for name, target in TARGETS.items()
    ]
    rows.append(["distance [tolerances]", "", *(f"{each.distance:.2f}" for each in best)])
    rows += [
        [f"`{name}`", "", *(_plain_number(plain(each.values)[name]) for each in best)]
        for name in ("ambient", "exposure", "live", "reading", "flashlight", "crosstalk", "gamma")
    ]
    left = [[name, "no grid to read" if value is None else f"{value:.2f}"] for name, value in without.items()]
    pairs = [[TARGETS[one].says, TARGETS[other].says] for one, other in excluded]
    parts = [
        f"*The best of {count} cameras with a grid to read; **bold** meets the target.*",
        markdown_table(head, rows),
        markdown_table([f"{best[0].room}, without", "distance"], left),
        markdown_table(["no camera meets both", "and"], pairs or [["-", "-"]]),
    ]
    return "\n\n".join(parts) + "\n"


def _shown(name: str, value: float) -> str:
    left = TARGETS[name].distance(value)
    return f"**{value:.2f}**" if left == 0 else f"{value:.2f} ({left:+.1f})"


def _plain_number(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cameras", type=int, default=300)
    chosen = parser.parse_args()
    scene, profile = search_scene(COLUMNS, ROWS), scaled(load_profile("published"), columns=COLUMNS, full=FULL)
    without_effects = [0.0] * len(EFFECT_NAMES)
    drawn_points = first_points(chosen.cameras, len(CAMERA_NAMES) - len(EFFECT_NAMES), seed=SEED)
    points = [[*without_effects, *point] for point in drawn_points.tolist()]
    found: list[Found] = []
    filmed = {}
    for room, name in OF_ROOM.items():
        filmed[room] = film_states(scene, {"rig.room": name})
        for point in points:
            quantities = read(filmed[room], scene.rig.camera, drawn(point), profile)
            if quantities is not None:
                found.append(
                    Found(room=room, values=drawn(point), distance=total_distance(quantities), quantities=quantities)
                )
        print(room, min(each.distance for each in found if each.room == room), flush=True)
    best = [min((each for each in found if each.room == room), key=lambda each: each.distance) for room in OF_ROOM]
    best.sort(key=lambda each: each.distance)
    without = {}
    for name, change in LEFT_OUT.items():
        quantities = read(filmed[best[0].room], scene.rig.camera, best[0].values | change, profile)
        without[name] = None if quantities is None else total_distance(quantities)
    together = [met(each.quantities) for each in found]
    pairs = exclusive(together)
    never = [name for name in TARGETS if not any(name in each for each in together)]
    result = {
        "cameras": len(found), "best": [asdict(each) | {"values": plain(each.values)} for each in best],
        "without": without, "exclusive": pairs, "never": never,
        "most_met": max(len(each) for each in together),
    }  # fmt: skip
    (chosen.out / "operating-rooms.json").write_text(json.dumps(result, indent=1) + "\n")
    text = tables(best, without, pairs, len(found))
    (chosen.out / "operating-rooms-tables.txt").write_text(text)
    print(text, never, result["most_met"], sep="\n")


if __name__ == "__main__":
    main()
