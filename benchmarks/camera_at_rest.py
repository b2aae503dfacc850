"""What the published detectors read of an untouched sensor behind a webcam, and what each effect of the camera adds.

    python benchmarks/camera_at_rest.py --out docs/benchmarks [--seeds 3] [--frames 30] [--later 60]

The untouched mini-magictac on `digit-webcam`, in the dark and in a room of 0.1 of the lights' unit, with all effects,
with each one left out, and with the camera of `digit-rgb`. A stream begins with 30 frames for the references; read are
the frames after them, and as many again a minute later. E, C and S by `published`: 10 %, median and 90 % of all
seeds. Writes `camera-at-rest.json` and, from it, `camera-at-rest.png`; goes on with a file that was begun.
H.264 needs the extra `video`.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from laboratory.benchmark import machine

from magicsim.camera.stream import CameraStream, Instant
from magicsim.detectors import DetectorProfile, detect, fuse, load_profile
from magicsim.errors import FrameError
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor, sensor_camera

ROOMS = {
    "dark, aim 90": ("rig.ambient=[0.0,0.0,0.0]", "rig.camera.exposure_grey=90"),
    "lit, aim 60": ("rig.ambient=[0.1,0.1,0.1]", "rig.camera.exposure_grey=60"),
    "dark, aim 60": ("rig.ambient=[0.0,0.0,0.0]", "rig.camera.exposure_grey=60"),
    "lit, aim 90": ("rig.ambient=[0.1,0.1,0.1]", "rig.camera.exposure_grey=90"),
}
"""Light of the room, and mean grey level that exposure aims at."""
DRAWN = tuple(ROOMS)[:2]
"""Where each effect is left out."""
WEBCAM = "rig=digit-webcam"
VARIANTS: dict[str, tuple[str, ...]] = {
    "all": (WEBCAM,),
    "without live exposure": (WEBCAM, "rig.camera.live.exposure=false", "rig.camera.live.white_balance=false"),
    "without flicker": (WEBCAM, "rig.camera.flicker.depth=0"),
    "without LED drift": (WEBCAM, "rig.camera.led_drift.share=0"),
    "without vibration": (WEBCAM, "rig.camera.vibration_px=0"),
    "without row noise, dark pattern, hot pixels": (WEBCAM, "rig.camera.faults={}"),
    "without MJPEG": (WEBCAM, "rig.camera.compression={kind='mjpeg',quality=100,chroma='444'}"),
    "without glare": (WEBCAM, "rig.camera.glare.share=0"),
    "tone curve of gamma 2.2": (WEBCAM, "rig.camera.gamma=2.2"),
    "H.264 instead of MJPEG": (WEBCAM, "rig.camera.compression={kind='h264'}"),
    "photon noise of digit-rgb": (WEBCAM, "rig.camera.full_well_e=250000", "rig.camera.read_noise_e=50"),
    "camera of digit-rgb": ("rig=digit-rgb",),
}
RATE = 15.0
REAL = {
    "entropy": [(0.4, 0.7, 0.8), (0.9, 2.0, 2.5)],
    "correlation": [(0.17, 0.21, 0.31), (0.43, 0.50, 0.78)],
    "similarity": [(0.99, 0.99, 0.99), (0.88, 0.95, 0.99)],
}
"""10 %, median, 90 % of a public see-through sensor of another make, untouched, with low and with bright LEDs."""
LABELS = {"entropy": "E [bit]", "correlation": "C", "similarity": "S"}


def camera_of(settings: tuple[str, ...], room: str) -> tuple[CameraStream, np.ndarray]:
    """The exposed camera of a variant, and the untouched sensor's radiance."""
    sensor = Sensor.for_scene(load_scene("rest", [*settings, *ROOMS[room]]))
    untouched = sensor.radiance(UNTOUCHED, sensor.rest)
    return sensor_camera(sensor, untouched), untouched


def read(
    stream: CameraStream, untouched: np.ndarray, profile: DetectorProfile, *, seed: int, frames: int, later_s: float
) -> list[dict[str, float]]:
    """E, C and S of the frames of one stream, with the mean grey level and the noise of single pixels."""
    memory, count = stream.begin(RATE), profile.reference_count
    late = count + round(later_s * RATE)
    looked_at = {*range(count, count + frames), *range(late, late + frames)}
    resting, found, references, before = [], [], None, None
    for index in range(late + frames):
        at = Instant(seed=seed, index=index, time_s=index / RATE, frames_per_second=RATE)
        if index >= count and index not in looked_at:
            memory = stream.passed(untouched, memory, at)
            continue
        image, memory = stream.take(untouched, memory, at)
        if index < count:
            resting.append(image)
            continue
        references = references or fuse(resting, profile)
        one = detect(image, references, profile)
        change = image.astype(float) - (before if before is not None else resting[-1])
        found.append(
            {name: float(getattr(one, name)) for name in LABELS}
            | {"late": float(index >= late), "grey": float(image.mean()), "noise": float(change.std() / np.sqrt(2))}
        )
        before = image
    return found


def quantiles(rows: list[dict[str, float]], name: str) -> list[float]:
    """10 %, median, 90 %."""
    return [round(float(each), 4) for each in np.quantile([row[name] for row in rows], (0.1, 0.5, 0.9))]


def measure(room: str, name: str, seeds: int, frames: int, later_s: float) -> list[dict[str, Any]]:
    """A variant in a room: right after the references, and later."""
    profile = load_profile("published")
    stream, untouched = camera_of(VARIANTS[name], room)
    first = Instant(seed=0, index=0, time_s=0.0, frames_per_second=RATE)
    dark_share = float((stream.take(untouched, stream.begin(RATE), first)[0] <= profile.tau_b).mean())
    row = {"room": room, "variant": name, "dark_share": round(dark_share, 3)}
    try:
        streams = [read(stream, untouched, profile, seed=seed, frames=frames, later_s=later_s) for seed in range(seeds)]
    except FrameError as error:
        return [row | {"later_s": 0.0, "refused": str(error)}]
    found = []
    for late in (False, True):
        rows = [each for one in streams for each in one if each["late"] == late]
        noise = round(float(np.median([each["noise"] for each in rows])), 3)
        told = {key: quantiles(rows, key) for key in (*LABELS, "grey")}
        found.append(row | {"later_s": later_s * late, "frames": len(rows), "pixel_noise_grey": noise} | told)
    return found


def plot(data: dict[str, Any], target: Path) -> None:
    """Bars from 10 to 90 % with the median, beside those of real frames."""
    import matplotlib as mpl

    mpl.use("agg")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5.5), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    names = list(VARIANTS)
    for axis, (quantity, label) in zip(axes, LABELS.items(), strict=True):
        for low, _, high in REAL[quantity]:
            axis.axvspan(low - 0.002, high + 0.002, color="0.85", zorder=0)
        for room, colour, shift in zip(DRAWN, ("C0", "C1"), (-0.18, 0.18), strict=True):
            for row in data["results"]:
                if row["room"] == room and not row["later_s"] and "refused" not in row:
                    place = names.index(row["variant"]) + shift
                    low, median, high = row[quantity]
                    axis.plot([low, high], [place, place], color=colour, lw=3, solid_capstyle="butt")
                    axis.plot(median, place, "o", color=colour, label=room if row["variant"] == "all" else None)
        axis.set_xlabel(label)
        axis.grid(axis="x", alpha=0.3)
    axes[0].set_yticks(range(len(names)), names)
    axes[0].invert_yaxis()
    axes[1].legend(title="room", loc="lower right", fontsize=8)
    figure.suptitle("Untouched frames, 10 % to 90 % and median; grey: a real see-through sensor, LEDs low and bright")
    figure.savefig(target, dpi=110)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--later", type=float, default=60.0)
    parser.add_argument("--plot", action="store_true", help="draw the plot again and measure nothing")
    chosen = parser.parse_args()
    file = chosen.out / "camera-at-rest.json"
    known = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {"results": []}
    done = {(row["room"], row["variant"]) for row in known["results"]}
    wanted = [(room, name) for room in ROOMS for name in VARIANTS if room in DRAWN or name == "all"]
    left = [each for each in wanted if each not in done]
    for room, name in [] if chosen.plot else left:
        rows = measure(room, name, chosen.seeds, chosen.frames, chosen.later)
        print("\n".join(json.dumps(row) for row in rows), flush=True)
        known["results"] += rows
        known |= {"kind": "camera-at-rest", "seeds": chosen.seeds, "machine": machine()}
        file.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    plot(known, chosen.out / "camera-at-rest.png")


if __name__ == "__main__":
    main()
