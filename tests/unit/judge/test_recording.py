"""Recorded frames take the place of rendered ones."""

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
from evaluation.conftest import built_in
from evaluation.synthetic import make_suite

from magicsim.errors import ConfigError
from magicsim.evaluation.evaluate import evaluate_suite
from magicsim.evaluation.footage import film_case
from magicsim.evaluation.suite import load_suite
from magicsim.evaluation.take import list_cases
from magicsim.judge.recorded import COLUMNS, TRUTH, read_recording

SUITE = """
schema_version = 1
design = "uniform-block"
rig = "digit-rgb"
resamples = 99
[[recordings]]
name = "bench-1"
folder = "bench-1"
object = "ball"
"""


def record(folder: Path, tmp_path: Path) -> Path:
    """Writes a rendered episode as if it had been recorded."""
    suite, cache = make_suite(tmp_path, objects=1)
    film = film_case(list_cases(suite)[0], suite, cache)[0]
    folder.mkdir()
    references, frames = list(film.images.references()), list(film.images.frames())
    names = [f"{number:05d}.png" for number in range(len(references) + len(frames))]
    for name, image in zip(names, [*references, *frames], strict=True):
        assert cv2.imwrite(str(folder / name), image[..., ::-1])
    blank = [("", 0.0, 0)] * len(references)
    labels = [
        ("" if np.isnan(gap) else gap, force, int(light))
        for gap, force, light in zip(
            film.labels.gap_mm.tolist(), film.labels.force_n.tolist(), film.labels.flashlight, strict=True
        )
    ]
    with (folder / TRUTH).open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for number, (name, label) in enumerate(zip(names, [*blank, *labels], strict=True)):
            writer.writerow([name, int(number < len(references)), *label])
    return folder


def test_recorded_frames_give_the_verdicts_of_the_rendered_ones(tmp_path: Path):
    record(tmp_path / "bench-1", tmp_path)
    (tmp_path / "mine.toml").write_text(SUITE)
    suite, cache = make_suite(tmp_path, objects=1)
    options = {"make": built_in(), "detector": "built-in", "cache": cache}
    rendered = evaluate_suite(suite, name="tiny", **options).episodes[0]
    found = evaluate_suite(load_suite(tmp_path / "mine.toml"), name="mine", **options)
    recorded = found.episodes[0]
    assert found.standard == "recorded/recorded"
    assert recorded.labels.classes == rendered.labels.classes
    assert recorded.proximity == rendered.proximity
    assert recorded.contact == rendered.contact
    assert np.array_equal(recorded.touch, rendered.touch)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("flashlight", "torch", "must be file, is_reference, gap_mm, force_n, flashlight"),
        ("00000.png,1", "00000.png,yes", "line 2: is_reference = 'yes' is not allowed: must be 0 or 1"),
        ("00000.png,1", "00000.png,0", "references; must be some, and all before the rest"),
        ("-1.0", "deep", "gap_mm = 'deep' is not allowed"),
        ("00004.png", "lost.png", "file 'lost.png' does not exist"),
        ("00004.png", "", "line 6: file is empty"),
    ],
)
def test_bad_table_is_one_line_that_names_it(tmp_path: Path, old: str, new: str, words: str):
    folder = record(tmp_path / "bench-1", tmp_path)
    text = (folder / TRUTH).read_text()
    assert old in text
    (folder / TRUTH).write_text(text.replace(old, new, 1))
    with pytest.raises(ConfigError) as caught:
        read_recording(folder)
    assert words in str(caught.value)


def test_folder_without_a_table_says_what_it_needs(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"holds no readable truth.csv, with the columns file, .* nor labels"):
        read_recording(tmp_path)
