"""Runs whose table is damaged or is another file, as frames that exist."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import tomli_w
from dataset.fakes import MIXED, small_recipe

from magicsim.dataset.generate import generate_dataset
from magicsim.errors import ConfigError
from magicsim.evaluation.detector import built_in
from magicsim.evaluation.evaluate import evaluate, evaluate_suite
from magicsim.evaluation.existing import StoredImages, existing_footage, read_existing
from magicsim.evaluation.footage import read_recordings
from magicsim.evaluation.page import describe
from magicsim.evaluation.suite import load_suite
from magicsim.folder import MARKER
from magicsim.judge.recorded import read_episode
from magicsim.judge.verdicts import TABLE
from magicsim.scenes.scene import load_scene
from magicsim.workers.attempt import WorkerOptions

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


def test_dataset_of_two_versions_of_the_code_is_refused_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "frames"))
    options = WorkerOptions(workers=1)
    generate_dataset(small_recipe("episodes=2"), tmp_path / "set", options=options, simulator=MIXED)
    with pytest.raises(ConfigError, match=r"/set' holds rows of two versions of the code: sources 0.*, sources .*;"):
        read_existing(tmp_path / "set", frames_per_second=1.0)


def test_frames_of_the_untouched_sensor_alone_are_refused(tmp_path: Path):
    cv2.imwrite(str(tmp_path / "0.png"), np.full((8, 6, 3), 20, np.uint8))
    (tmp_path / "labels.csv").write_text("file,class\n0.png,Reference\n0.png,Reference\n0.png,Reference\n")
    suite, films = existing_footage(tmp_path, load_suite("small"))
    for each in ([films], []):
        with pytest.raises(ConfigError, match="'set' holds no frames to judge"):
            evaluate_suite(suite, built_in("published"), name="set", detector="x", cache=Path(), films=each)


def test_recording_with_classes_alone_is_judged_and_says_its_sensor(tmp_path: Path):
    for number in range(5):
        cv2.imwrite(str(tmp_path / f"{number}.png"), np.full((8, 6, 3), 40 * number, np.uint8))
    lines = ["0.png,Reference", "1.png,Clear", "2.png,Contact", "3.png,Light", "4.png,"]
    (tmp_path / "labels.csv").write_text("\n".join(["file,class", *lines]))
    [film] = read_existing(tmp_path, frames_per_second=1.0).films
    assert film.labels.classes == ("Clear", "Contact", "Light", None)
    assert film.labels.flashlight.tolist() == [False, False, True, False]
    assert film.tag.sensor == "recorded"
    assert [int(each.mean()) for each in film.images.frames()] == [40, 80, 120, 160]
    (tmp_path / "suite.toml").write_text(
        'schema_version = 1\ndesign = "mini-magictac"\nrig = "digit-office"\n'
        '[[recordings]]\nname = "mine"\nfolder = "."\nsensor = "STS 7"\n'
    )
    [recorded] = read_recordings(load_suite(tmp_path / "suite.toml"))
    assert (recorded.tag.sensor, recorded.labels.classes) == ("STS 7", film.labels.classes)


def test_real_frames_that_are_shipped_are_a_suite_of_their_own_sensor():
    suite = load_suite(Path(__file__).resolve().parents[3] / "docs/real-frames/suite.toml")
    found = evaluate_suite(suite, built_in("calibrated", is_coated=True), name="9dtact", detector="x", cache=Path())
    by_name = evaluate(suite, "calibrated", cache=Path())
    assert np.array_equal(by_name.episodes[0].touch, found.episodes[0].touch)
    assert found.as_dict()["sensors"] == {"9dtact-ball": "9DTact, unit 1"}
    assert found.not_judged.startswith("proximity: design.coat is opaque")
    assert found.confusion["contact"]["Contact"].keys() == {"Touched", "Untouched", "Unknown"}
    assert sum(found.confusion["contact"]["Contact"].values()) == 1
    assert "sensors: 9DTact, unit 1 (1 episodes)" in "\n".join(describe(found))
