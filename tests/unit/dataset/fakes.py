"""Episodes that cost nothing: importable by name, so that other processes can make them."""

import io
import json
import math
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
from PIL import Image

from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.recipe import Recipe, load_recipe
from magicsim.dataset.rows import SampleTask
from magicsim.dataset.shard import rows_as_bytes, schema_of_columns
from magicsim.errors import ConvergenceError
from magicsim.workers.attempt import Work, WorkerOptions

FOLDER = Path(__file__).parent
TURNED = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
SMALL = (
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=24", "rig.camera.rows=32",
    "rig.camera.field_mm=10", "design.lattice.cells_across=0",
)  # fmt: skip


def small_recipe(*more: str, seed: int | None = None) -> Recipe:
    return load_recipe(FOLDER / "small.toml", [*SMALL, *more], seed=seed)


def telling_rows(task: SampleTask) -> bytes:
    """Rows whose images are those of the made-up sensor of evaluations: in turn clear, near, touched, and lit."""
    from evaluation.synthetic import seen_state

    def change(row: dict, number: int) -> None:
        gap_mm = (math.nan, 1.0, -0.4, math.nan)[number % 4] if number >= 0 else math.nan
        force_n, is_lit = float(gap_mm < 0), number % 4 == 3 and number >= 0
        pixels = seen_state(gap_mm, str(task.episode.index), is_lit=is_lit)
        noise = np.random.default_rng([task.episode.index, number + 1000]).normal(0, 1, pixels.shape)
        png = cv2.imencode(".png", np.clip(120 * pixels + noise, 0, 255).astype(np.uint8)[..., ::-1])[1].tobytes()
        row |= {"image": {"bytes": png, "path": None}, "gap_mm": gap_mm, "flashlight": is_lit}
        row |= {"force_n": [0.0, 0.0, force_n], "contact": force_n > 0}

    return fake_rows(task, change)


def mixed_rows(task: SampleTask) -> bytes:
    """Rows of which those of episode 1 were made by other sources."""
    other = {"version": task.constants["version"].replace("sources ", "sources 0")} if task.episode.index == 1 else {}
    return fake_rows(task, lambda row, _: row.update(other))


def loose_rows(task: SampleTask) -> bytes:
    """Rows whose forces are balanced to a thousandth."""
    return fake_rows(task, lambda row, _: row.update(force_balance=1e-3))


def fake_rows(task: SampleTask, change: Callable[[dict, int], None] | None = None) -> bytes:
    """Rows with the right columns, content from the episode's seed, after a short while."""
    episode, count = task.episode, task.episode.scene.frame_count + task.episode.scene.references
    time.sleep(float(os.environ.get("FAKE_SECONDS", "0")))
    random = np.random.default_rng(episode.scene.seed)
    rows = []
    for step in range(count):
        row = {}
        for column in task.columns:
            row[column.name] = _value(column, random, episode.scene.rig.camera)
        rows.append(row | task.constants | {"episode": episode.index, "step": step, "sensor": episode.sensor})
        rows[-1] |= {"contact": False, "force_n": [0.0] * 3, "force_balance": 0.0, "seed": episode.scene.seed}
        rows[-1] |= {"is_reference": step < episode.scene.references}
        rows[-1] |= {"path_kind": episode.path_kind, "time_s": step / 15, "gap_mm": math.nan}
        rows[-1] |= {"object_rotation": TURNED, "camera_rotation": TURNED}
        if change is not None:
            change(rows[-1], step - episode.scene.references)
    arrays = [pa.array([row[column.name] for row in rows], column.arrow) for column in task.columns]
    return rows_as_bytes(pa.Table.from_arrays(arrays, schema=schema_of_columns(task.columns)))


def _value(column, random: np.random.Generator, camera) -> object:
    kind = column.feature["_type"]
    if kind == "Image":
        channels = (3,) if column.name == "image" else ()
        pixels = random.integers(0, 256, (camera.rows, camera.columns, *channels), np.uint8)
        return {"bytes": cv2.imencode(".png", pixels)[1].tobytes(), "path": None}
    if kind == "Array2D":
        rows, width = column.feature["shape"]
        return random.random((rows or 4, width), np.float32).tolist()
    if kind == "Sequence":
        return random.random(column.feature["length"]).tolist()
    dtype = column.feature["dtype"]
    plain = {"string": "word", "bool": False}
    return plain[dtype] if dtype in plain else int(random.integers(9)) if dtype.startswith("int") else random.random()


def failing_rows(task: SampleTask) -> bytes:
    """Episode 1 has no answer; episode 2 crashes as long as a file says so."""
    if task.episode.index == 1:
        msg = "the deformation did not reach a valid equilibrium"
        raise ConvergenceError(msg)
    if task.episode.index == 2 and Path(os.environ["FAKE_CRASH"]).exists():
        os.kill(os.getpid(), signal.SIGKILL)
    return fake_rows(task)


def _variant() -> str:
    return "none"


FAKE = Work(function=fake_rows, prepare=None, variant=_variant)
TELLING = Work(function=telling_rows, prepare=None, variant=_variant)
MIXED = Work(function=mixed_rows, prepare=None, variant=_variant)
FAILING = Work(function=failing_rows, prepare=None, variant=_variant)


def decoded(value: dict) -> np.ndarray:
    """Pixels of an image column's value, by another decoder than magicsim's."""
    return np.asarray(Image.open(io.BytesIO(value["bytes"])))


def content(out: Path) -> dict[str, bytes]:
    """All files of a dataset but the error log, by name."""
    files = [path for path in sorted(out.rglob("*")) if path.is_file() and path.name != "errors.jsonl"]
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in files}


if __name__ == "__main__":
    folder, workers, episodes = sys.argv[1:]
    summary = generate_dataset(
        small_recipe(f"episodes={episodes}"),
        Path(folder),
        options=WorkerOptions(workers=int(workers)),
        resume=True,
        simulator=FAKE,
    )
    sys.stdout.write(json.dumps({"samples": summary.samples}))
