import csv
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from magicsim import calibrate
from magicsim.detectors import detect_all, fuse, load_profile, score_verdicts
from magicsim.judge.recorded import read_episode

from .conftest import Shell

FEW = ["--set", "reference_count=4", "--set", "tau_b=[35,50]", "--set", "grid_blur_px=0"]


def frames(seed: int) -> list[tuple[str, np.ndarray]]:
    """References and three frames of every class, of a dark grid on a bright ground."""
    rng = np.random.default_rng(seed)
    row, column = np.indices((32, 24))
    rest = np.where((row % 6 < 2) | (column % 6 < 2), 10, 80)[..., None].repeat(3, axis=2)
    made = [("Reference", rest)] * 4
    for _ in range(3):
        pressed = rest + rng.integers(0, 20, rest.shape)
        pressed[10:] = 80 + rng.integers(0, 60, pressed[10:].shape)
        made += [
            ("Clear", rest),
            ("Near", rest + rng.integers(0, 20, rest.shape)),
            ("Contact", pressed),
            ("", rest + 5),
            ("Light", rest + rng.integers(0, 150, (32, 24, 1))),
        ]
    return [(name, (image + (rng.random(image.shape) < 0.1)).astype(np.uint8)) for name, image in made]


def write_images(folder: Path, seed: int) -> list[tuple[str, str]]:
    folder.mkdir()
    rows = []
    for number, (name, image) in enumerate(frames(seed)):
        file = f"{number:02}.png"
        assert cv2.imwrite(str(folder / file), image[..., ::-1])
        rows.append((file, name))
    return rows


def recording(folder: Path, seed: int) -> Path:
    with (folder.parent / "table").open("w") as table:
        writer = csv.writer(table)
        writer.writerow(("file", "class"))
        writer.writerows(write_images(folder, seed))
    (folder.parent / "table").rename(folder / "labels.csv")
    return folder


def run_folder(folder: Path, seed: int) -> Path:
    rows = [
        {"file": file, "is_reference": name == "Reference", "frame_class": None if name in {"", "Reference"} else name}
        for file, name in write_images(folder, seed)
    ]
    pq.write_table(pa.Table.from_pylist(rows), folder / "episode.parquet")
    return folder


def test_profile_fitted_to_recordings_judges_another_one_rightly(shell: Shell, tmp_path: Path):
    first, second, third = (recording(tmp_path / str(seed), seed) for seed in (1, 2, 3))
    found = shell.json("calibrate", first, second, "--out", "mine.toml", *FEW)
    assert (found["proximity_accuracy"], found["contact_accuracy"]) == (1.0, 1.0)
    assert (found["cross_validated_proximity_accuracy"], found["cross_validated_contact_accuracy"]) == (1.0, 1.0)
    assert found["frames"] == {"Clear": 6, "Near": 6, "Contact": 6, "Light": 6}
    assert {each["area"] for each in found["roc"].values()} == {1.0}
    profile = load_profile(tmp_path / "mine.toml")
    assert (profile.reference_count, profile.grid_blur_px) == (4, 0)
    assert profile.tau_b in {35, 50}
    assert found["options"]["tau_g"] == profile.tau_g
    episode = read_episode(third)
    verdicts = detect_all(episode.frames, fuse(episode.references, profile), profile)
    assert score_verdicts(verdicts, episode.classes).contact.accuracy == 1.0


def test_folder_of_a_simulation_and_a_recording_of_the_same_frames_give_the_same_fit(tmp_path: Path):
    options = ["reference_count=4", "tau_b=35", "grid_blur_px=0", "polarity=dark"]
    one = calibrate([run_folder(tmp_path / "run", 1)], tmp_path / "a.toml", settings=options)
    other = calibrate([recording(tmp_path / "real", 1)], tmp_path / "b.toml", settings=options)
    assert one.options == other.options
    assert one.candidates == 1 * 1 * 3 * 1 * 3
    assert one.cross_validated_contact_accuracy is None
    assert "run" in (tmp_path / "a.toml").read_text().splitlines()[0]


def test_operating_points_are_those_of_the_fitted_verdicts(tmp_path: Path):
    """An untouched frame labelled as contact: hits and false alarms of `touch` are what the verdicts give."""
    folder = recording(tmp_path / "a", 1)
    text = (folder / "labels.csv").read_text().replace("04.png,Clear", "04.png,Contact")
    (folder / "labels.csv").write_text(text)
    fitted = calibrate([folder], tmp_path / "a.toml", settings=["reference_count=4", "tau_b=35"])
    profile, episode = load_profile(tmp_path / "a.toml"), read_episode(folder)
    verdicts = detect_all(episode.frames, fuse(episode.references, profile), profile)
    judged = [
        (each == "Contact", verdict.combined == "Touched")
        for verdict, each in zip(verdicts, episode.classes, strict=True)
        if each is not None and verdict.proximity != "Noise"
    ]
    hits = [touched for is_contact, touched in judged if is_contact]
    alarms = [touched for is_contact, touched in judged if not is_contact]
    touch = fitted.roc["touch"]
    assert (touch.hit_rate, touch.false_alarm_rate) == pytest.approx((np.mean(hits), np.mean(alarms)))
    assert 0 < touch.hit_rate < 1
    assert touch.area < 1
    assert (touch.false_alarm_rate, touch.hit_rate) in [pytest.approx(point) for point in touch.curve]


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--out", "a.toml"], "episodes are missing"),
        (["none", "--out", "a.toml"], "'none' is no labelled episode; give a folder that holds episode.parquet"),
        (["real", "--out", "a.txt"], "out = a.txt is not allowed; must end in .toml"),
        (["real", "--out", "no/a.toml"], "no such folder"),
        (["real", "--out", "a.toml", "--base", "publishd"], "did you mean 'published'"),
        (["real", "--out", "a.toml", "--set", "tau_bb=3"], "unknown option 'tau_bb' (did you mean 'tau_b'?)"),
        (["real", "--out", "a.toml", "--set", "tau_e=3"], "unknown option 'tau_e'"),
        (["real", "--out", "a.toml", "--set", "tau_b=[35,999]"], "tau_b = 999 is not allowed"),
        (["real", "--out", "a.toml", "--set", "tau_b=[]"], "tau_b = [] is not allowed"),
        (["real", "--out", "a.toml", "--set", "grey=max"], "grey = 'max' is not allowed; must be one of: luma, mean"),
        (["broken", "--out", "a.toml"], "episode.parquet' cannot be read"),
        (["partial", "--out", "a.toml"], "no frame of class Light"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_profile(shell: Shell, tmp_path: Path, arguments: list[str], named: str):
    recording(tmp_path / "real", 1)
    partial = recording(tmp_path / "partial", 1) / "labels.csv"
    partial.write_text(partial.read_text().replace("Light", ""))
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "episode.parquet").write_text("x")
    assert named in shell.refusal("calibrate", *arguments)
    assert not list(tmp_path.rglob("a.*"))
