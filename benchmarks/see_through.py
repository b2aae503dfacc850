"""Fits `detectors/see-through-markers.toml` on simulated sensors, and predicts what it will find on real recordings.

    python benchmarks/see_through.py --cache takes            # films, fits, predicts; goes on where it was stopped
    python benchmarks/see_through.py --cache takes --film 2   # films two more takes at most

The sensor is `see-through-markers`. Units, LEDs, rooms and cameras are drawn (`laboratory.see_through.sensors`), with
dim and with bright LEDs in turn; sensors and objects of the fit are none of the test's. Options and thresholds are
fitted as those of `calibrated` (`magicsim.detectors.calibrate`), without its margin of E from frames at rest.
The test's frames are read with that profile, and with `published` and `calibrated` beside it. Nothing of a real
recording is used. Writes `docs/see-through.json` and, from it, `docs/see-through-tables.txt`.
"""

import argparse
import json
import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from laboratory.markdown import markdown_table
from laboratory.see_through.reading import FEATURES, SHARES, STATES, Reading, exposed, features, read, shares
from laboratory.see_through.sensors import OBJECTS, DrawnSensor, draw_sensors

from magicsim.detectors.calibrate import Candidates, fit_profile
from magicsim.detectors.features import Episode
from magicsim.detectors.profile import load_profile, save_profile
from magicsim.errors import FrameError
from magicsim.evaluation.take import cached_take, take_key

TRAINING, TEST = 8, 8
LIGHTS = ("dim", "bright")
PROFILE = Path("detectors/see-through-markers.toml")
CANDIDATES = Candidates(
    tau_b=(15, 25, 35, 50, 65, 80, 90, 95),
    polarity=("dark", "bright"),
    similarity=("recall", "iou", "dice"),
    grid_blur_px=(5,),
    difference_blur_px=(0, 5, 9),
    surround_px=(0, 6, 12),
)
NO_MARGIN = -1000.0
"""Standard deviations that the threshold of E stays from untouched frames: none. Behind a webcam that exposes by itself
E at rest spreads over bits, and four deviations from the worst sensor would leave no approach to be told."""
WISHES = {
    "contact_balanced": (0.85, "at least"),
    "untouched_called": (0.05, "at most"),
    "near_balanced": (0.8, "at least"),
}
COMMENT = """Fitted by benchmarks/see_through.py on eight simulated sensors of the type see-through-markers: units,
LEDs (dim and bright), rooms and cameras drawn at random, six objects. No real recording was used; docs/see-through.md
says what it is expected to find on one."""


def left_to_film(sensors: Sequence[DrawnSensor], cache: Path) -> list[DrawnSensor]:
    """Sensors without a take."""
    return [each for each in sensors if not (cache / f"{take_key(each.scene)}.npz").is_file()]


def judged(sensors: Sequence[DrawnSensor], episodes: Sequence[Episode], name: str) -> list[Reading] | str:
    """Readings of all sensors by a profile, or why there are none."""
    profile = load_profile(name)
    try:
        return [read(sensor, episode, profile) for sensor, episode in zip(sensors, episodes, strict=True)]
    except FrameError as error:
        return str(error)


def told(readings: list[Reading]) -> dict[str, Any]:
    """All figures of one profile, by lights."""
    groups = {each: [one for one in readings if one.lights == each] for each in LIGHTS}
    return {
        "shares": {"all": shares(readings)} | {name: shares(group) for name, group in groups.items()},
        "features": {name: features(group) for name, group in groups.items()},
    }


def tables(found: dict[str, Any]) -> str:
    """Markdown of the page."""
    fitted = found["profiles"][str(PROFILE)]
    lines = []
    for name, says in SHARES.items():
        cells = [_share(fitted["shares"][group][name]) for group in ("all", *LIGHTS)]
        lines.append([says, *cells, _wish(name, fitted["shares"]["all"][name])])
    parts = [markdown_table(["", "all", "LEDs dim", "LEDs bright", "wished"], lines)]
    for title, profile in (("by the fitted profile", str(PROFILE)), ("by `published`", "published")):
        told_of = found["profiles"][profile]
        if "refused" in told_of:
            parts.append(f"{title}: {told_of['refused']}")
            continue
        rows = [
            [f"LEDs {lights}", state, *(_feature(told_of["features"][lights][state][name]) for name in FEATURES)]
            for lights in LIGHTS
            for state in STATES
        ]
        parts.append(markdown_table([title, "state", "E [bit]", "C", "S"], rows))
    rows = [
        [f"`{name}`" if name != str(PROFILE) else "`see-through-markers`",
         *(_share(each["shares"]["all"][key]) for key in WISHES)]
        for name, each in found["profiles"].items()
        if "shares" in each
    ]  # fmt: skip
    parts.append(markdown_table(["profile", *(SHARES[key] for key in WISHES)], rows))
    return "\n\n".join(parts) + "\n"


def _share(one: dict[str, Any]) -> str:
    low, high = one["interval"]
    least, most = one["sensors"]
    return f"**{one['mean']:.2f}** ({low:.2f} to {high:.2f}; {least:.2f} to {most:.2f})"


def _wish(name: str, one: dict[str, Any]) -> str:
    if name not in WISHES:
        return ""
    bound, words = WISHES[name]
    met = one["mean"] >= bound if words == "at least" else one["mean"] <= bound
    return f"{words} {bound:g}: {'met' if met else 'missed'}"


def _feature(one: dict[str, list[float]]) -> str:
    low, middle, high = one["frames"]
    least, most = one["sensors"]
    return f"{low:.2f} **{middle:.2f}** {high:.2f} ({least:.2f} to {most:.2f})"


def main() -> None:
    """Films what is missing, fits, predicts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cache", type=Path, required=True, help="folder of takes")
    parser.add_argument("--film", type=int, help="film at most so many takes, and nothing else")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    training, test = draw_sensors("training", TRAINING), draw_sensors("test", TEST)
    arguments.cache.mkdir(parents=True, exist_ok=True)
    left = left_to_film([*training, *test], arguments.cache)
    for each in left[: arguments.film]:
        cached_take(each.scene, arguments.cache)
        logging.info("filmed %s", each.name)
    if arguments.film is not None:
        return
    episodes = {each.name: exposed(each, cached_take(each.scene, arguments.cache)) for each in [*training, *test]}
    fitted = fit_profile(
        load_profile("published"), [episodes[each.name] for each in training], CANDIDATES, entropy_margin_sd=NO_MARGIN
    )
    save_profile(fitted.profile, PROFILE, comment=COMMENT)
    found: dict[str, Any] = {
        "sensors": {
            "training": TRAINING,
            "test": TEST,
            "objects": {key: [one[0] for one in each] for key, each in OBJECTS.items()},
        },
        "fit": {
            "proximity_accuracy": fitted.best.proximity_accuracy,
            "contact_accuracy": fitted.best.contact_accuracy,
            "held_out_accuracy": fitted.best.held_out_accuracy,
        },
        "profiles": {},
    }
    for name in (str(PROFILE), "published", "calibrated"):
        readings = judged(test, [episodes[each.name] for each in test], name)
        found["profiles"][name] = {"refused": readings} if isinstance(readings, str) else told(readings)
    Path("docs/see-through.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    Path("docs/see-through-tables.txt").write_text(tables(found), encoding="utf-8")


if __name__ == "__main__":
    main()
