"""How long a live sensor waits for its first frame and its second, and how much of it all frames of a sensor share.

    python benchmarks/first_frame.py --out docs/benchmarks/first-frame.json

Each row is a process of its own, from the moment at which magicsim is imported. `build_seconds` are those of
`live_sensor(...)`. The first `frame()` is of the untouched sensor and the second of an object 1 mm away, where nothing
is solved; both with what all frames of the sensor share, whose seconds stand beside: `careful_seconds` the untouched
sensor's careful image, its records and the exposure, in the first frame, and `cheap_seconds` its image and records with
the samples of a frame, in the second.

`no cache`: nothing kept on disk of this sensor. `cache kept`: the untouched sensor is there from the run before. Both
find kernels that were compiled before; `nothing compiled` finds neither kernels of Dr.Jit nor the sensor, as the first
run on a machine does.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

GAP_MM = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstFrames:
    """One process."""

    state: str
    build_seconds: float
    first_frame_seconds: float
    careful_seconds: float
    second_frame_seconds: float
    cheap_seconds: float


def measure(state: str, scene: str, settings: list[str]) -> FirstFrames:
    """Times a live sensor in this process."""
    from magicsim.robot import live_sensor
    from magicsim.scenes.timeline import UNTOUCHED
    from magicsim.simulation.sensor import sensor_exposure

    times = [time.perf_counter()]
    live = live_sensor(scene, settings)
    times.append(time.perf_counter())
    # What frames would do first; they find it done.
    sensor_exposure(live.sensor, live.sensor.radiance(UNTOUCHED, live.sensor.rest))
    times.append(time.perf_counter())
    live.frame()
    times.append(time.perf_counter())
    live.move_to(gap_mm=GAP_MM, x_mm=0, y_mm=0)
    live.sensor.renderer.prepare(live.sensor.view(live.state, live.deformation))
    times.append(time.perf_counter())
    live.frame()
    times.append(time.perf_counter())
    build, careful, first, cheap, second = (after - before for before, after in pairwise(times))
    return FirstFrames(
        state=state, build_seconds=round(build, 2), first_frame_seconds=round(careful + first, 2),
        careful_seconds=round(careful, 2), second_frame_seconds=round(cheap + second, 2), cheap_seconds=round(cheap, 2),
    )  # fmt: skip


def in_own_process(state: str, scene: str, settings: list[str], cache: Path, home: Path | None) -> FirstFrames:
    """`measure` with a cache of its own.

    Args:
        state: What it is called.
        scene: Name of a scene.
        settings: Overrides.
        cache: Folder of untouched sensors.
        home: Folder in which Dr.Jit looks for kernels, None for the user's.
    """
    command = [sys.executable, __file__, "--measure", state, "--scene", scene]
    command += [part for each in settings for part in ("--set", each)]
    environment = os.environ | {"MAGICSIM_CACHE": str(cache)} | ({"HOME": str(home)} if home is not None else {})
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return FirstFrames(**json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--scene", default="pressed")
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--repeat", type=int, default=3, help="processes of each row")
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.measure is not None:
        print(json.dumps(asdict(measure(chosen.measure, chosen.scene, chosen.settings))))
        return
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(chosen.repeat):
            kept, home = Path(folder) / f"kept {turn}", Path(folder) / f"home {turn}"
            for state, cache, own_home in (
                ("no cache", kept, None), ("cache kept", kept, None), ("nothing compiled", home / "cache", home),
            ):  # fmt: skip
                cache.mkdir(parents=True, exist_ok=True)
                rows.append(in_own_process(state, chosen.scene, chosen.settings, cache, own_home))
                print(json.dumps(asdict(rows[-1])), flush=True)
    if chosen.out is not None:
        found = {"scene": chosen.scene, "settings": chosen.settings, "results": [asdict(row) for row in rows]}
        chosen.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
