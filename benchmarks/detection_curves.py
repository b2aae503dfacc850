"""How probably a touch or an object is detected, against depth, force and gap, by object and room.

    python benchmarks/detection_curves.py --out docs/benchmarks        # six minutes on two cores, beside other work

Each state of each object before the default sensor in each room is rendered once and photographed `DRAWS` times. Told
are, by the profile `calibrated`: the share of photographs called Touched against depth and force, and called
Approaching against the gap, with exact 95 % intervals; and what the measure S itself can do in that room: the share
of photographs whose S is below the level that the untouched sensor falls below once an hour (normal law of 60
photographs at rest, 15 frames a second), and below that of the same object at the gap at which it looks most like a
touch. The smallest touches are those from which on 90 % are called Touched, and below the level beside near frames.
Writes detection-curves.json and .png.
"""

import argparse
import json
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import takewhile
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from scipy.stats import norm

from magicsim.arrays import FloatImage, Frame
from magicsim.camera.camera import Camera
from magicsim.camera.exposure import Exposure, expose, meter
from magicsim.detectors import detect, fuse, load_profile
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.judge.measures import exact_share
from magicsim.light.records.untouched_store import shared_states
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor

OBJECTS = {
    "ball of 5 mm": "object={kind='sphere',radius_mm=5.0,color=[0.85,0.45,0.15]}",
    "dark ball of 3 mm": "object={kind='sphere',radius_mm=3.0,color=[0.25,0.25,0.3]}",
    "punch of 3 mm": "object={kind='punch',radius_mm=3.0,edge_radius_mm=0.5,color=[0.6,0.15,0.1]}",
}
ROOMS = {
    "office": (), "bench, dim": ("rig.room='bench'", "rig.ambient=[0.02,0.02,0.02]"), "dark": ("rig.room='dark'",),
}  # fmt: skip
GAPS_MM = (30.0, 20.0, 10.0, 5.0, 2.0, 0.5)
DEPTHS_MM = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8, 1.2)
DRAWS = 40
AT_REST = 60
AN_HOUR = 15 * 3600
"""Frames."""
WANTED = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class CurveRow:
    """One state."""

    room: str
    object: str
    gap_mm: float
    force_n: float
    approaching: float
    touched: float
    low: float
    high: float
    """Of `touched` in contact, of `approaching` before it."""
    similarity: float
    """Median S."""
    below_hourly: float
    """Share of photographs whose S is below the level of one false alarm an hour of the untouched sensor."""
    below_near: float | None
    """Below that of the same object before contact; None before contact."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SmallestTouch:
    """Of one object in one room."""

    room: str
    object: str
    told_by: str
    """`verdict` of the profile, or `S` below its level beside near frames."""
    depth_mm: float | None
    """None where no depth of the series suffices."""
    force_n: float | None


def measure(profile: DetectorProfile) -> list[CurveRow]:
    """All states."""
    rows, pressed = [], {}
    for room, settings in ROOMS.items():
        for name, thing in OBJECTS.items():
            scene = load_scene("pressed", [thing, *settings])
            sensor = Sensor.for_scene(scene, untouched=shared_states())
            rest = sensor.radiance(UNTOUCHED, sensor.rest)
            shoot = partial(_photograph, exposure=meter(rest, scene.rig.camera, scene.rig.lit), camera=scene.rig.camera)
            references = fuse([shoot(rest, number) for number in range(profile.reference_count)], profile)
            frame = profile.reference_count
            still = [detect(shoot(rest, frame + number), references, profile).similarity for number in range(AT_REST)]
            frame += AT_REST
            hourly, beside_near = _hourly_level(still), np.inf
            deformation = sensor.rest
            for gap in (*GAPS_MM, *(-depth for depth in DEPTHS_MM)):
                state = replace(UNTOUCHED, gap_mm=gap)
                if gap < 0:
                    if (name, gap) not in pressed:
                        pressed[name, gap] = sensor.deform(state, deformation)
                    deformation = pressed[name, gap]
                radiance = sensor.radiance(state, deformation)
                said = [detect(shoot(radiance, frame + number), references, profile) for number in range(DRAWS)]
                frame += DRAWS
                similarities = np.array([each.similarity for each in said])
                if gap > 0:
                    beside_near = min(beside_near, _hourly_level(similarities))
                near = sum(each.proximity == Proximity.APPROACHING for each in said)
                touch = sum(each.combined == Contact.TOUCHED for each in said)
                share = exact_share(touch if gap < 0 else near, DRAWS)
                rows.append(
                    CurveRow(
                        room=room, object=name, gap_mm=gap, force_n=float(np.linalg.norm(deformation.force_n)),
                        approaching=near / DRAWS, touched=touch / DRAWS, low=share.low, high=share.high,
                        similarity=float(np.median(similarities)),
                        below_hourly=float(np.mean(similarities < hourly)),
                        below_near=float(np.mean(similarities < beside_near)) if gap < 0 else None,
                    )
                )  # fmt: skip
                print(json.dumps(asdict(rows[-1])), flush=True)
    return rows


def _photograph(radiance: FloatImage, frame: int, *, exposure: Exposure, camera: Camera) -> Frame:
    return expose(radiance, exposure, camera, seed=5, frame=frame)


def _hourly_level(similarities: npt.ArrayLike) -> float:
    """What S of frames like these falls below once an hour, by a normal law."""
    return float(np.mean(similarities) + norm.ppf(1 / AN_HOUR) * np.std(similarities, ddof=1))


def smallest_touches(rows: list[CurveRow]) -> list[SmallestTouch]:
    """Depth from which on all deeper states are told as often as wanted."""
    found = []
    for room in ROOMS:
        for name in OBJECTS:
            touched = [row for row in rows if (row.room, row.object) == (room, name) and row.gap_mm < 0]
            deepest_first = sorted(touched, key=lambda each: each.gap_mm)
            for told_by, share in (("verdict", "touched"), ("S", "below_near")):
                told = list(takewhile(lambda row, share=share: getattr(row, share) >= WANTED, deepest_first))
                depth, force = (-told[-1].gap_mm, told[-1].force_n) if told else (None, None)
                found.append(SmallestTouch(room=room, object=name, told_by=told_by, depth_mm=depth, force_n=force))
    return found


def plot(rows: list[CurveRow], path: Path) -> None:
    """Touched against depth and force, Approaching against the gap; a colour a room, a line an object."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained", sharey=True)
    for color, room in zip(("C0", "C1", "C2"), ROOMS, strict=True):
        for style, name in zip(("-", "--", ":"), OBJECTS, strict=True):
            mine = [row for row in rows if (row.room, row.object) == (room, name)]
            touched, near = ([row for row in mine if (row.gap_mm < 0) == deep] for deep in (True, False))
            label = f"{name}, {room}"
            axes[0].plot([-row.gap_mm for row in touched], [row.touched for row in touched], color + style)
            axes[1].plot([row.force_n for row in touched], [row.touched for row in touched], color + style)
            axes[2].plot([row.gap_mm for row in near], [row.approaching for row in near], color + style, label=label)
    for axis, label in zip(axes, ("depth [mm]", "force [N]", "gap [mm]"), strict=True):
        axis.set(xscale="log", xlabel=label, ylim=(-0.03, 1.03))
    axes[0].set_ylabel("called Touched")
    axes[2].set_title("called Approaching", fontsize=10)
    figure.legend(loc="outside right center", fontsize=7)
    figure.savefig(path, dpi=110)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--profile", default="calibrated")
    chosen = parser.parse_args()
    rows = measure(load_profile(chosen.profile))
    touches = smallest_touches(rows)
    found = {
        "profile": chosen.profile,
        "smallest": [asdict(each) for each in touches],
        "results": [asdict(row) for row in rows],
    }
    chosen.out.mkdir(parents=True, exist_ok=True)
    (chosen.out / "detection-curves.json").write_text(json.dumps(found, indent=1) + "\n")
    plot(rows, chosen.out / "detection-curves.png")


if __name__ == "__main__":
    main()
