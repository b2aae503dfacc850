"""Studies that learn, in their small form, on made frames."""

from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim_experiments.study.running import run_study
from magicsim_experiments.study.study_file import load_study

from .made_touches import MADE

TINY = (
    "rig.camera.columns=24", "rig.camera.rows=32", "camera_scale=1.0", "check_episodes=3", "learning.epochs=12",
    "learning.folds=2", "learning.folds_used=1", "learning.long_side_px=0", "learning.curve=[0.5]",
)  # fmt: skip


def made(name: str | Path, *overrides: str, tiny: tuple[str, ...] = TINY):
    """A study in its small form whose data are made."""
    study = load_study(name, [*tiny, *overrides], quick=True)
    for each in study.stages():
        stage = getattr(each, "stage", each)  # of a comparison
        if hasattr(stage, "simulator"):
            object.__setattr__(stage, "simulator", MADE)
    return study


def run(study, out: Path, **options):
    pytest.importorskip("torch")
    pytest.importorskip("safetensors")
    return run_study(study, out, variant=lambda: "none", **options)


def rows(out: Path, table: str) -> list[dict]:
    return pq.read_table(out / f"tables/{table}.parquet").to_pylist()


def contents(out: Path) -> dict[str, bytes]:
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}
