import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.errors import ConfigError, FrameError, OutputError
from magicsim.frame_class import FrameClass
from magicsim.judge.recorded import read_episode, read_recording
from magicsim.judge.verdicts import TABLE, write_table
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.episode import Episode, FrameLabels, FrameTruth, SimulatedFrame, SolveFigures, frame_file
from magicsim.simulation.main_job import write_frames

CLASSES = (None, None, FrameClass.CLEAR, None, FrameClass.LIGHT)


def frame(index: int) -> SimulatedFrame:
    return SimulatedFrame(
        image=np.random.default_rng(index).integers(0, 256, (16, 12, 3), dtype=np.uint8),
        truth=FrameTruth(
            index=index, time_s=0.0, is_reference=index < 2, state=UNTOUCHED, contact=False, depth_mm=0.0,
            force_n=(0.0, 0.0, 0.0), torque_nmm=(0.0, 0.0, 0.0), contact_area_mm2=0.0, frame_class=CLASSES[index],
            solve=SolveFigures(iterations=0, min_jacobian=1.0, max_penetration_mm=0.0, force_balance=0.0),
        ),
        labels=FrameLabels(),
    )  # fmt: skip


@pytest.fixture
def episode() -> Episode:
    return Episode(scene=load_scene("rest"), frames=tuple(frame(index) for index in range(5)))


@pytest.fixture
def folder(tmp_path: Path, episode: Episode) -> Path:
    write_frames(tmp_path, episode)
    write_table(tmp_path / TABLE, episode, [])
    return tmp_path


def test_what_a_simulation_wrote_is_read_back(folder: Path, episode: Episode):
    found = read_episode(folder)
    assert list(found.classes) == list(CLASSES[2:])
    images = [*found.references, *found.frames]
    assert len(found.references) == 2
    assert all(np.array_equal(one, each.image) for one, each in zip(images, episode.frames, strict=True))


def test_frame_that_is_missing_is_named(folder: Path):
    (folder / frame_file(3)).unlink()
    with pytest.raises(FrameError, match=r"00003\.png"):
        read_episode(folder)


def test_folder_without_labels_is_named(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"episode\.parquet \(magicsim simulate\), truth\.csv or labels\.csv"):
        read_episode(tmp_path)


def test_recording_with_true_states_gives_the_classes_of_the_scoring(tmp_path: Path):
    images = np.random.default_rng(0).integers(0, 256, (5, 16, 12, 3), dtype=np.uint8)
    for number, image in enumerate(images):
        assert cv2.imwrite(str(tmp_path / f"{number}.png"), image[..., ::-1])
    lines = ["0.png,1,,0,0", "1.png,0,,0,0", "2.png,0,1.5,0,0", "3.png,0,-0.5,0.8,0", "4.png,0,,0,1"]
    (tmp_path / "truth.csv").write_text("\n".join(["file,is_reference,gap_mm,force_n,flashlight", *lines]))
    found = read_episode(tmp_path)
    assert list(found.classes) == [FrameClass.CLEAR, FrameClass.NEAR, FrameClass.CONTACT, FrameClass.LIGHT]
    np.testing.assert_array_equal(found.references[0], images[0])
    np.testing.assert_array_equal(found.frames[2], images[3])


@pytest.mark.parametrize(
    ("columns", "force", "size_n"),
    [
        ("force_n", "0.8", 0.8),
        ("force_z_n", "0.8", 0.8),
        ("force_x_n,force_y_n,force_z_n", "0.3,0,0.4", 0.5),
        ("force_z_n,force_x_n,force_y_n", "0.4,0.3,", 0.5),
    ],
)
def test_force_of_a_recording_is_a_size_a_vector_or_the_normal_force(
    tmp_path: Path, columns: str, force: str, size_n: float
):
    for number in range(2):
        assert cv2.imwrite(str(tmp_path / f"{number}.png"), np.zeros((16, 12, 3), np.uint8))
    none = "," * columns.count(",")
    lines = [f"file,is_reference,gap_mm,flashlight,{columns}", f"0.png,1,,0,{none}", f"1.png,0,-0.5,0,{force}"]
    (tmp_path / "truth.csv").write_text("\n".join(lines))
    found = read_recording(
        tmp_path
    ).force_n  # that of the reference is unknown, of one with an empty part at least so large
    assert found.tolist() == pytest.approx([np.nan, size_n], nan_ok=True)
    assert list(read_episode(tmp_path).classes) == [FrameClass.CONTACT]


@pytest.mark.parametrize("columns", ["force_x_n,force_z_n", "force_n,force_z_n", "force_x_n", "fz"])
def test_table_with_other_columns_of_force_says_which_there_may_be(tmp_path: Path, columns: str):
    (tmp_path / "truth.csv").write_text(f"file,is_reference,gap_mm,flashlight,{columns}\n0.png,1,,0,1,1\n")
    with pytest.raises(ConfigError, match="or instead of force_n force_x_n, force_y_n, force_z_n or force_z_n alone"):
        read_recording(tmp_path)


def test_label_that_was_not_asked_for_says_what_to_set(episode):
    frame = episode.frames[0]
    with pytest.raises(OutputError, match=r"depth_map_mm was not computed: set output\.depth_map = true"):
        _ = frame.depth_map_mm
    with pytest.raises(OutputError, match=r"set output\.displacements = true"):
        _ = frame.displacements_mm
    with pytest.raises(OutputError, match=r"set output\.contact_mask = true"):
        _ = frame.contact_mask


def recorded(folder: Path, *lines: str) -> Path:
    """A recording of dots with this table."""
    for line in lines:
        assert cv2.imwrite(str(folder / line.partition(",")[0]), np.zeros((16, 12, 3), np.uint8))
    heading = "file,is_reference,gap_mm,force_n,flashlight"
    (folder / "truth.csv").write_text("\n".join([heading, *lines, ""]))
    return folder


def test_empty_force_is_unknown_and_never_no_contact(tmp_path: Path):
    folder = recorded(
        tmp_path, "0.png,1,,0,0", "1.png,0,,,0", "2.png,0,-0.5,,0", "3.png,0,,2.5,0", "4.png,0,1.5,,0", "5.png,0,,0,0"
    )
    expected = [None, None, None, FrameClass.NEAR, FrameClass.CLEAR]
    assert list(read_episode(folder).classes) == expected
    assert np.isnan(read_recording(folder).labels.force_n).tolist() == [True, True, False, True, False]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["0.png,1,-1.5,0,0", "1.png,0,,0,0"], "line 2: a reference has gap_mm = -1.5; must be of the untouched"),
        (["0.png,1,,6.6,0", "1.png,0,,0,0"], "line 2: a reference has a force of 6.6 N"),
        (["0.png,1,,0,0", "1.png,0,1,5,0,0"], "line 3: 6 cells; must be 5, as in the heading; a number has a decimal"),
        (["0.png,1,,0,0", "1.png,0,,0"], "line 3: 4 cells; must be 5, as in the heading"),
        (["0.png,1,,0,0", "1.png,0,,0,0", "1.png,0,,0,0"], "file '1.png' stands in 2 lines; must be in one"),
        (["0.png,1,,0,0", "1.png,0,,1_0,0"], "line 3: force_n = '1_0' is not allowed: must be a finite number"),
    ],
)
def test_row_that_is_not_clear_is_one_line(tmp_path: Path, lines: list[str], said: str):
    with pytest.raises(ConfigError, match=said):
        read_recording(recorded(tmp_path, *lines))


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("{}.png,0,-0.0015,6.6,0", "gap_mm reaches a depth of 0.0015 mm, which is no press: metres?"),
        ("{}.png,0,-1.5,6600,0", "force_n reaches 6600 N, more than such a sensor bears: mN or grams?"),
        ("{}.png,0,5,0.4,0", "force_n is 0.4 N from the first frame on, .*: not tared?"),
        ("{}.png,0,-0.4,0.5,0", "gap_mm is a depth of 0.4 mm from the first frame on"),
        ("{}.png,0,-1.5,0,0", "force_n and gap_mm disagree in 6 frames"),
    ],
)
def test_number_that_no_sensor_has_is_told(tmp_path: Path, caplog, row: str, said: str):
    read_recording(recorded(tmp_path, "0.png,1,,,0", *(row.format(number) for number in range(1, 7))))
    assert re.search(said, caplog.text)


def test_order_of_lines_that_numbers_do_not_follow_is_told(tmp_path: Path, caplog):
    read_recording(recorded(tmp_path, "0.png,1,,0,0", "1.png,0,,0,0", "10.png,0,,0,0", "2.png,0,,0,0"))
    assert "in the order of the lines, which their numbers do not follow" in caplog.text


def test_sound_recording_has_no_remark(tmp_path: Path, caplog):
    rows = [f"{number}.png,0,{gap},{force},0" for number, gap, force in ((1, "", 0), (2, 2, 0), (10, -0.5, 0.8))]
    read_recording(recorded(tmp_path, "0.png,1,,0,0", *rows))
    assert not caplog.records
