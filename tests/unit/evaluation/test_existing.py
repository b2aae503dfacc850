"""Runs whose table is damaged or is another file, as frames that exist."""

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import tomli_w

from magicsim.errors import ConfigError
from magicsim.evaluation.existing import StoredImages, read_existing
from magicsim.folder import MARKER
from magicsim.judge.recorded import read_episode
from magicsim.judge.verdicts import TABLE
from magicsim.scenes.scene import load_scene

ROWS = {
    "file": ["frames/00000.png", "frames/00001.png"], "is_reference": [True, False], "frame_class": ["", "near"],
    "gap_mm": [None, 1.0], "force_n": [[0.0] * 3, [0.0, 0.0, 1.0]], "flashlight": [False, False],
}  # fmt: skip


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = tmp_path / "run"
    folder.mkdir()
    scene = load_scene("pressed").model_dump(mode="json", exclude_none=True)
    (folder / MARKER).write_text(tomli_w.dumps(scene))
    pq.write_table(pa.table(ROWS), folder / TABLE)
    return folder


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[-20] ^= 0xFF
    path.write_bytes(content)


def put(**changed: object) -> Callable[[Path], None]:
    return lambda path: pq.write_table(pa.table({name: each for name, each in (ROWS | changed).items() if each}), path)


def test_rows_of_a_run_are_an_episode(run: Path):
    (film,) = read_existing(run, frames_per_second=1.0).films
    assert isinstance(film.images, StoredImages)
    assert film.labels.gap_mm.tolist() == [1.0]
    assert film.labels.force_n.tolist() == [1.0]


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda path: path.write_bytes(b""), "cannot be read: "),
        (lambda path: path.write_bytes(b"\x89PNG" * 100), "cannot be read: "),
        (lambda path: path.write_bytes(path.read_bytes()[:300]), "cannot be read: "),
        (flip, "cannot be read: "),
        (put(file=None), "cannot be read: .*file"),
        (put(file=[None, "a.png"]), "cannot be read: .*file.*null"),
        (put(is_reference=["a", "b"]), "cannot be read: "),
    ],
)
def test_table_that_is_damaged_is_refused_by_name(run: Path, damage: Callable[[Path], object], said: str):
    damage(run / TABLE)
    for read in (lambda: read_existing(run, frames_per_second=1.0), lambda: read_episode(run)):
        with pytest.raises(ConfigError, match=rf"^'{run / TABLE}' {said}"):
            read()


def test_unknown_class_is_refused_by_name(run: Path):
    put(frame_class=["", "zzz"])(run / TABLE)
    with pytest.raises(ConfigError, match=rf"^'{run / TABLE}': unknown frame_class 'zzz'"):
        read_episode(run)
