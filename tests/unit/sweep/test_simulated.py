"""A real sweep, small: four designs, killed half-way and gone on with."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
FOLDER = Path(__file__).parent
SETTINGS = (
    "design.footprint_mm=[12,16]", "rig.camera.field_mm=10",
    'swept=[{field="design.cell_mm", values=[0.8, 1.2]}, {field="design.skin_mm", values=[0.5, 1.5]}]',
)  # fmt: skip


def test_killed_sweep_goes_on_and_shows_the_published_trends(tmp_path: Path):
    out = tmp_path / "sweep"
    command = [sys.executable, "-m", "magicsim", "sweep", str(FOLDER / "small.toml"), "--out", str(out), "--json"]
    command += [part for each in SETTINGS for part in ("--set", each)]
    environment = {**os.environ}
    run = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 3600
    while not list(out.glob("designs/*.json")) and run.poll() is None and time.monotonic() < deadline:
        time.sleep(0.2)
    run.send_signal(signal.SIGKILL)
    run.wait()
    finished = {path.name: path.read_bytes() for path in out.glob("designs/*.json")}
    assert 1 <= len(finished) < 4
    done = subprocess.run([*command, "--resume"], env=environment, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert (found["designs"], found["failed"]) == (4, 0)
    assert all((out / "designs" / name).read_bytes() == content for name, content in finished.items())
    rows = list(csv.DictReader((out / "sweep.csv").read_text(encoding="utf-8").splitlines()))
    assert all(float(row["force_1mm_n_low"]) <= float(row["force_1mm_n"]) for row in rows)
    trends = {each["statement"]: each["holds"] for each in found["trends"]}
    assert trends["thicker skin, stiffer"]
    assert trends["thicker skin, harder"]
