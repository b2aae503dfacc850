"""References are frames of the untouched sensor: what labels and pixels say against that is refused or told."""

import re
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.dataset.frames import open_frames
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.inspection import inspect_real
from magicsim.dataset.real.writing import write_real
from magicsim.errors import ConfigError

from .drawn import describe, pressed, save, untouched, write_csv

FORCES_N = [0.0] * 6 + [0.3, 0.6, 0.9, 0.4]


@pytest.fixture(autouse=True)
def _kept(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "kept"))


def recording(folder: Path, change=lambda number, image: image, **columns: list) -> Path:
    """References 0 to 5 as they are changed, and four frames of a press, with labels."""
    values = {"f": FORCES_N} | columns
    rows = []
    for number, force in enumerate(FORCES_N):
        image = pressed(force, number)
        image = change(number, image.astype(float)) if number < 6 else image
        save(folder / "images" / f"{number}.png", np.clip(np.rint(image), 0, 255).astype(np.uint8))
        rows.append({"image_name": f"{number}.png"} | {name: each[number] for name, each in values.items()})
    write_csv(folder / "labels.csv", rows)
    known = {
        "f": 'force_n = "f"',
        "depth": 'depth_mm = "depth"',
        "gap": 'gap_mm = "gap"',
        "what": 'frame_class = "what"',
    }
    top = f"columns = {{{', '.join(known[name] for name in values)}}}"
    return describe(folder, 'frames = "images"', 'labels = "labels.csv"', "untouched_first = 6", top=[top])


def told(path: Path) -> list[str]:
    return inspect_real(load_real(path)).told


@pytest.mark.parametrize(
    "labels",
    [
        {"f": [0.0] * 3 + [0.5] + [0.0] * 6},
        {"gap": [""] * 3 + [-0.4] + [5.0] * 6},
        {"what": ["Clear"] * 3 + ["Contact"] * 7},
    ],
)
def test_reference_that_is_a_contact_by_its_labels_is_refused(tmp_path: Path, labels):
    with pytest.raises(ConfigError, match=r"recordings\[0\]: reference '3.png' is a contact.* by its labels"):
        write_real(load_real(recording(tmp_path, **labels)), tmp_path / "set")


def test_known_force_of_a_reference_is_kept(tmp_path: Path):
    path = recording(tmp_path, f=[0.01, -0.02, "", 0.03, 0, 0, *FORCES_N[6:]])
    write_real(load_real(path), tmp_path / "set")
    found = open_frames(tmp_path / "set", ("force_n", "is_reference")).column("force_n")[:, 2]
    assert found.tolist() == pytest.approx([0.01, -0.02, 0, 0.03, 0, 0, *FORCES_N[6:]])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda number, image: 0 * image if number < 2 else image, "reference frames 0, 1 are black"),
        (lambda number, image: image * [1, 0.6, 1] if number < 2 else image, "0, 1 have other colours"),
        (lambda number, image: image * (0.7 + 0.06 * number), "references drift, with 8. to 11. % of their usual"),
        (lambda number, image: image * (0.8 if number == 0 else 1), r"references drift, .* \(frames 0\)"),
        (lambda number, image: 0 * image if number < 4 else image, "reference frames 0, 1, 2 and 1 more are black"),
        (lambda number, image: image * [1.4, 0.7, 1.4], "colours differ from the untouched frames'"),
        (lambda _, image: 0 * image, "references are black, with a mean grey level of 0.0 of 255, and frames are not"),
        (lambda _, image: image[::-1, ::-1], "look like their references only when they are turned by 180 degrees"),
    ],
)  # fmt: skip
def test_references_that_are_odd_are_named_and_no_gain_is_advised(tmp_path: Path, change, said: str):
    found = told(recording(tmp_path, change))
    assert any(re.search(said, each) for each in found)
    assert not any("gain" in each for each in found)


def test_touched_reference_is_told_as_detect_tells_it(tmp_path: Path):
    found = told(recording(tmp_path, lambda number, image: pressed(1.0, number) if number == 5 else image))
    assert any(
        "1 of 6 reference frames do not look untouched beside the others, the first of them frame 5" in each
        for each in found
    )


@pytest.mark.parametrize(
    ("labels", "said"),
    [
        ({"f": [0.0] * 6 + [300, 600, 900, 400]}, "force_n reaches 900 N, more than such a sensor bears: mN or grams?"),
        ({"f": [0.0] * 6 + [0.0003, 0.0006, 0.0009, 0.0004]}, "force_n reaches 0.0009 N, which is no touch: kN or kg?"),
        ({"depth": [0.0] * 6 + [0.0003, 0.0006, 0.0009, 0.0004]}, "depth_mm reaches a depth of 0.0009 mm, .* metres?"),
        ({"depth": [0.0] * 6 + [300, 600, 900, 400]}, "depth_mm reaches a depth of 900 mm, .* micrometres?"),
        ({"depth": [0.0] * 6 + [0.4] * 4, "f": [0.0] * 10}, "force_n and depth_mm disagree in 4 frames"),
    ],
)
def test_number_that_no_sensor_has_is_told(tmp_path: Path, labels, said: str):
    assert any(re.search(said, each) for each in told(recording(tmp_path, **labels)))


def test_force_that_was_not_tared_is_told(tmp_path: Path):
    recording(tmp_path, f=[0.3 + each for each in FORCES_N])
    for number in range(6):
        save(tmp_path / "free" / f"{number}.png", untouched(90 + number))
    lines = ('frames = "images"', 'labels = "labels.csv"', 'untouched = "free"')
    found = told(describe(tmp_path, *lines, top=['columns = {force_n = "f"}']))
    assert any(
        "force_n is 0.3 N from the first frame on, a contact before anything touches: not tared?" in each
        for each in found
    )


def test_empty_force_is_unknown_in_class_and_contact(tmp_path: Path):
    path = recording(tmp_path, f=[*FORCES_N[:6], 0.3, "", 0.9, 0.0])
    write_real(load_real(path), tmp_path / "set")
    frames = open_frames(tmp_path / "set", ("frame_class", "force_n", "is_reference"))
    assert frames.column("frame_class")[6:].tolist() == ["Contact", "", "Contact", ""]
    assert np.isnan(frames.column("force_n")[7]).all()
    with pytest.raises(ConfigError, match="unknown column 'contact'"):
        open_frames(tmp_path / "set", ("contact",))
    assert any("of 1 frames no label tells whether something touches" in each for each in told(path))


def test_sensor_that_looks_alike_from_two_sides_is_told_with_all_that_fit_and_nothing_to_set(tmp_path: Path):
    columns = np.mgrid[0:60, 0:80][1]
    image = np.stack([200 - 2 * columns, 20 + 0 * columns, 40 + 2 * columns], 2).astype(np.uint8)
    for number in range(6):
        save(tmp_path / "like" / f"{number}.png", image)
        save(tmp_path / "images" / f"{number}.png", np.ascontiguousarray(image[::-1, ::-1]))
    truth = [
        {"file": f"{each}.png", "is_reference": int(each < 5), "gap_mm": "", "force_n": 0, "flashlight": 0}
        for each in range(6)
    ]
    write_csv(tmp_path / "like" / "truth.csv", truth)
    path = describe(tmp_path, 'frames = "images"', "untouched_first = 3", top=['like = "like"'])
    [line] = [each for each in told(path) if "several settings fit alike" in each]
    settings = ["rotate_deg = 180 and frames.mirror = false", "rotate_deg = 0 and frames.mirror = true"]
    assert all(each in line for each in [*settings, 'frames.color_order = "bgr"'])
    assert not any(": set frames" in each for each in told(path))


def test_times_count_from_the_first_frame_where_the_untouched_ones_come_last(tmp_path: Path):
    rows = []
    for number, force in enumerate([0.9, 0.6, 0.3, 0.0, 0.0]):
        save(tmp_path / "images" / f"{number}.png", np.asarray(pressed(force, number), np.uint8))
        rows.append({"image_name": f"{number}.png", "f": force, "t": 10 + 0.5 * number})
    write_csv(tmp_path / "labels.csv", rows)
    top = ['columns = {force_n = "f", time_s = "t"}']
    path = describe(tmp_path, 'frames = "images"', 'labels = "labels.csv"', "untouched_below_n = 0.1", top=top)
    write_real(load_real(path), tmp_path / "set")
    (table,) = (pq.read_table(each) for each in (tmp_path / "set" / "data").glob("*.parquet"))
    assert table["is_reference"].to_pylist() == [True] * 2 + [False] * 3
    assert table["time_s"].to_pylist() == pytest.approx([1.5, 2.0, 0.0, 0.5, 1.0])


def test_untouched_frames_that_no_detector_gets_are_told(tmp_path: Path):
    for number in range(36):
        save(tmp_path / "images" / f"{number:02}.png", np.asarray(untouched(number), np.uint8))
    path = describe(tmp_path, 'frames = "images"', "untouched_first = 35")
    lines = told(path)
    assert any("the first 30 of 35 untouched frames serve as references" in line for line in lines), lines
