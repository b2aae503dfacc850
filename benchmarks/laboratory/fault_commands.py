"""Small real runs of the commands that write folders, for `faults.py`: how they are called and what they leave."""

import csv
import hashlib
import io
import json
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

SENSOR = """
schema_version = 1
rig = "digit-rgb"
design = "mini-magictac"
seed = 3
"""
BALL = """
[object]
kind = "sphere"
radius_mm = 3.0
"""
SCENE = f"""{SENSOR}
references = 6
{BALL}
[[keyframes]]
frame = 0
gap_mm = 1.0
[[keyframes]]
frame = 3
gap_mm = -0.6
"""
RECIPE = f"""{SENSOR}
episodes = 6
episodes_per_sensor = 3
episodes_per_shard = 2
[[objects]]
kind = "sphere"
radius_mm = {{ low = 2.0, high = 5.0 }}
[[paths]]
kind = "touch"
depth_mm = {{ low = 0.3, high = 0.8 }}
approach_frames = 2
press_frames = 1
shear_frames = 0
twist_frames = 0
hold_frames = 1
release_frames = 1
[[paths]]
kind = "flashlight"
lit_frames = 2
"""
SWEEP = f"""{SENSOR}
sampling = "sobol"
count = 200
measures = ["printability"]
objectives = [{{ measure = "printability", better = "higher" }}]
{BALL}
[[swept]]
field = "design.cell_mm"
low = 0.6
high = 1.2
[[swept]]
field = "design.skin_mm"
low = 0.3
high = 1.2
"""
"""Many designs that are judged at once: what is tried is the folder, and it is written all the time."""
SUITE = f"""{SENSOR}
references = 6
resamples = 99
objects = [{{ name = "ball", object = "sphere:radius_mm=3", role = "training" }},
           {{ name = "finger", object = "finger", role = "held_out", press_mm = 0.6 }}]
paths = [{{ name = "touch", frames = [{{ frame = 0 }}, {{ frame = 2, gap_mm = 2.0 }}, {{ frame = 3, press = 1.0 }}] }}]
lights = [{{ name = "dark" }}]
episodes = [{{ objects = ["ball", "finger"], paths = ["touch"], lights = ["dark"] }}]
"""
COARSE = (
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=48", "rig.camera.rows=64",
    "rig.camera.field_mm=14", "render.samples=2", "render.particles=4000", "render.anchor_samples=4",
    "render.anchor_particles=20000",
)  # fmt: skip
FILES = {"scene.toml": SCENE, "recipe.toml": RECIPE, "sweep.toml": SWEEP, "suite.toml": SUITE}
TIMED = frozenset({"seconds", "milliseconds_per_frame"})
"""Keys of an evaluation that name a time."""
TIMED_FILES = frozenset({"sweep.json", "sweep.parquet", "report.html"})
"""Files of a sweep that hold times, beside the designs'."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """One command that writes a folder."""

    name: str
    arguments: tuple[str, ...]
    """Without `--out`."""
    again: tuple[str, ...] = ()
    """What goes on with a folder that a killed run has left; nothing where the whole is made again."""
    others: tuple[str, ...] = ()
    """Names of folders that the command also writes, as options."""

    def argv(self, out: Path, *, resume: bool = False) -> list[str]:
        """The whole command line."""
        more = [f"{option}={out.parent / (out.name + option)}" for option in self.others]
        chosen = self.again if resume else ()
        return [sys.executable, "-m", "magicsim", *self.arguments, *chosen, *more, "--out", str(out), "--json"]

    def run(self, out: Path, *, resume: bool = False, timeout_s: float = 600) -> subprocess.CompletedProcess[str]:
        """Runs it to its end."""
        return subprocess.run(
            self.argv(out, resume=resume), capture_output=True, text=True, timeout=timeout_s, check=False
        )

    def start(self, out: Path, *, resume: bool = False) -> subprocess.Popen[str]:
        """Begins it."""
        return subprocess.Popen(
            self.argv(out, resume=resume), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )


def commands(work: Path) -> dict[str, Command]:
    """The commands, with their configuration files below a folder."""
    for name, text in FILES.items():
        (work / name).write_text(text, encoding="utf-8")
    coarse = tuple(part for each in COARSE for part in ("--set", each))
    block = tuple(part for each in COARSE[:2] for part in ("--set", each))
    return {
        "simulate": Command(name="simulate", arguments=("simulate", str(work / "scene.toml"), *coarse)),
        "dataset": Command(
            name="dataset", arguments=("dataset", str(work / "recipe.toml"), *coarse, "--workers", "2"),
            again=("--resume",),
        ),
        "sweep": Command(
            name="sweep", arguments=("sweep", str(work / "sweep.toml"), *block, "--workers", "2"),
            again=("--resume",),
        ),
        "evaluate": Command(
            name="evaluate", arguments=("evaluate", str(work / "suite.toml"), *coarse), others=("--cache",)
        ),
    }  # fmt: skip


def content(folder: Path) -> dict[str, str]:
    """SHA-256 of every file of a folder by name, without the times that a run took: `TIMED`."""
    names = (path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*")) if path.is_file())
    untimed = {
        "sweep.csv": _untimed_table, "evaluation.json": _untimed_object, "report.html": _untimed_page,
    }  # fmt: skip
    is_sweep = (folder / "sweep.json").exists()
    found = {}
    for name in names:
        # What a sweep's table and page are made from holds the same times; the list of a result their hashes.
        if name in {"errors.jsonl", ".magicsim.json"} or (is_sweep and name in TIMED_FILES | set(_designs(name))):
            continue
        data = (folder / name).read_bytes()
        found[name] = hashlib.sha256(untimed[name](data.decode()) if name in untimed else data).hexdigest()
    return found


def _designs(name: str) -> tuple[str, ...]:
    return (name,) if name.startswith("designs/") else ()


def _untimed_table(text: str) -> bytes:
    rows = csv.DictReader(io.StringIO(text))
    return repr([{key: value for key, value in row.items() if "seconds" not in key} for row in rows]).encode()


def _untimed_object(text: str) -> bytes:
    return repr({key: value for key, value in json.loads(text).items() if key not in TIMED}).encode()


def _untimed_page(text: str) -> bytes:
    return re.sub(r"[0-9.]+ ms, on the machine", "ms, on the machine", text).encode()
