"""Recorded frames become a dataset with the columns of a simulated one, from every layout."""

from pathlib import Path

import numpy as np
import pytest

from dataset.fakes import decoded
from magicsim.dataset.columns import columns_of
from magicsim.dataset.export.formats import export_dataset
from magicsim.dataset.export.source import open_dataset
from magicsim.dataset.frames import FrameTable, open_frames
from magicsim.dataset.real import writing
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.writing import write_real
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.dataset.verify import verify_dataset
from magicsim.errors import ConfigError, FrameError, OutputError
from magicsim.folder.listing import sealed

from .drawn import describe, pressed, public_set, save, untouched, video, write_csv

FORCES_N = [0.0, 0.01, 0.4, 0.0, 1.0, 0.0]


@pytest.fixture(autouse=True)
def _kept(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "kept"))


def written(description: Path, out: Path, *settings: str, columns: tuple[str, ...] = ()) -> FrameTable:
    write_real(load_real(description, settings), out)
    return open_frames(out, columns or None)


def test_public_layout_becomes_rows_with_references_first(tmp_path: Path):
    frames = written(public_set(tmp_path, FORCES_N), tmp_path / "set")
    assert frames.column("is_reference").tolist() == [True] * 4 + [False] * 2
    assert frames.column("step").tolist() == list(range(6))
    assert frames.column("force_n")[4:].tolist() == [pytest.approx([0.04, 0, 0.4]), pytest.approx([0.1, 0, 1.0])]
    assert frames.column("frame_class").tolist() == [""] * 4 + ["Contact"] * 2
    assert frames.column("contact").tolist() == [False] * 4 + [True] * 2
    assert np.array_equal(frames[4]["image"], pressed(0.4, 2))
    assert np.array_equal(frames[1]["image"], untouched(1))


def test_columns_have_the_names_and_types_of_simulated_ones(tmp_path: Path):
    write_real(load_real(public_set(tmp_path, FORCES_N)), tmp_path / "set")
    simulated = {each.name: each for each in columns_of(load_recipe("default"))}
    for column in open_dataset(tmp_path / "set").columns:
        assert column.arrow == simulated[column.name].arrow
        assert column.feature == simulated[column.name].feature


def test_dataset_verifies_and_exports(tmp_path: Path):
    write_real(load_real(public_set(tmp_path, FORCES_N)), tmp_path / "set")
    assert verify_dataset(tmp_path / "set").problems == []
    export_dataset(tmp_path / "set", tmp_path / "tars", "webdataset")
    export_dataset(tmp_path / "set", tmp_path / "h5", "hdf5")
    with pytest.raises(ConfigError, match="format = mcap is not allowed for recorded frames"):
        export_dataset(tmp_path / "set", tmp_path / "logs", "mcap")


def test_hugging_face_reads_it(tmp_path: Path):
    datasets = pytest.importorskip("datasets")
    write_real(load_real(public_set(tmp_path, FORCES_N)), tmp_path / "set")
    rows = datasets.load_dataset(str(tmp_path / "set"), split="train", cache_dir=str(tmp_path / "cache"))
    assert np.array_equal(np.asarray(rows[4]["image"]), pressed(0.4, 2))
    assert rows[4]["force_n"] == pytest.approx([0.04, 0, 0.4])


def test_own_names_units_and_episodes(tmp_path: Path):
    rows = []
    for number, (press, depth) in enumerate([("a", 0.0), ("a", 0.0005), ("b", 0.001)]):
        save(tmp_path / "shots" / f"shot{number}.png", pressed(1000 * depth, number))
        row = {
            "shot": f"shot{number}",
            "press": press,
            "z_m": depth,
            "x": 1,
            "y": -2,
            "t": 0.2 * number,
            "what": "ball",
        }
        rows.append(row)
    write_csv(tmp_path / "log.csv", rows)
    for number in range(3):
        save(tmp_path / "free" / f"{number}.png", untouched(90 + number))
    top = [
        'columns = {image = "shot", episode = "press", depth_mm = "z_m", place_mm = ["x", "y"], time_s = "t",'
        ' object_kind = "what"}',
        "scale.depth_mm = 1000",
    ]
    path = describe(tmp_path, 'frames = "shots"', 'labels = "log.csv"', 'untouched = "free"', "sensor = 3", top=top)
    frames = written(
        path, tmp_path / "set",
        columns=("episode", "is_reference", "depth_mm", "gap_mm", "frame_class", "object_position_mm", "sensor",
                 "object_kind", "time_s"),
    )  # fmt: skip
    assert frames.column("episode").tolist() == [0] * 5 + [1] * 4
    assert frames.column("is_reference").tolist() == [True] * 3 + [False] * 2 + [True] * 3 + [False]
    assert frames.column("depth_mm")[[4, 8]].tolist() == pytest.approx([0.5, 1.0])
    assert frames.column("gap_mm")[8] == pytest.approx(-1.0)
    assert frames.column("frame_class")[[3, 4, 8]].tolist() == ["", "Contact", "Contact"]
    assert frames.column("object_position_mm")[4, :2].tolist() == [1, -2]
    assert set(frames.column("sensor").tolist()) == {3}
    assert frames.column("object_kind")[4] == "ball"
    assert frames.column("time_s")[[3, 4]].tolist() == pytest.approx([0.0, 0.2])
    assert open_dataset(tmp_path / "set").frames_per_second == pytest.approx(5.0)


def test_video_takes_labels_by_time(tmp_path: Path):
    times = [0.0, 0.033, 0.066, 0.12, 0.2]
    forces = [0.0, 0.0, 0.5, 1.0, 0.2]
    video(tmp_path / "press.mkv", [pressed(force, number) for number, force in enumerate(forces)], times)
    clock = [{"t": 100 + 0.01 * step, "f": np.interp(0.01 * step, times, forces)} for step in range(21)]
    write_csv(tmp_path / "force.csv", clock)
    path = describe(
        tmp_path, 'frames = "press.mkv"', 'labels = "force.csv"', "offset_s = 100.0", "untouched_first = 2",
        top=['columns = {time_s = "t", force_n = "f"}'],
    )  # fmt: skip
    frames = written(path, tmp_path / "set", columns=("image", "time_s", "force_n", "is_reference", "contact"))
    assert frames.column("time_s").tolist() == pytest.approx(times, abs=1e-3)
    assert frames.column("force_n")[2:, 2].tolist() == pytest.approx([0.5, 1.0, 0.2], abs=0.06)
    assert frames.column("contact").tolist() == [False, False, True, True, True]
    assert np.array_equal(frames[3]["image"], pressed(1.0, 3))


def test_frames_are_brought_into_form_before_they_are_stored(tmp_path: Path):
    path = public_set(tmp_path, FORCES_N)
    frames = written(path, tmp_path / "set", "frames.rotate_deg=90", "frames.size_px=[30,40]", "recordings=" + (
        '[{frames="images",labels="labels.csv",untouched_below_n=0.02,gain=0.5}]'
    ))  # fmt: skip
    assert frames[0]["image"].shape == (40, 30, 3)
    assert frames[5]["image"].mean() < 0.7 * frames[0]["image"].mean()  # gain is of frames, not of references


def test_stopped_run_goes_on_to_the_same_bytes(tmp_path: Path, monkeypatch):
    for name in ("a", "b"):
        public_set(tmp_path / name, FORCES_N)
    both = "\n".join(
        f'[[recordings]]\nframes = "{name}/images"\nlabels = "{name}/labels.csv"\nuntouched_first = 2' for name in "ab"
    )
    path = tmp_path / "both.toml"
    path.write_text(f"schema_version = 1\n{both}\n", encoding="utf-8")
    write_real(load_real(path), tmp_path / "whole")
    made, real_rows = [], writing.frame_row

    def dies(*args, **kwargs):
        made.append(1)
        if len(made) == 9:
            raise KeyboardInterrupt
        return real_rows(*args, **kwargs)

    monkeypatch.setattr(writing, "frame_row", dies)
    with pytest.raises(KeyboardInterrupt):
        write_real(load_real(path), tmp_path / "stopped")
    with pytest.raises(OutputError, match="unfinished dataset"):
        open_dataset(tmp_path / "stopped")
    with pytest.raises(OutputError, match="--resume goes on"):
        write_real(load_real(path), tmp_path / "stopped")
    monkeypatch.setattr(writing, "frame_row", real_rows)
    write_real(load_real(path), tmp_path / "stopped", resume=True)
    names = sorted(each.relative_to(tmp_path / "whole") for each in (tmp_path / "whole").rglob("*") if each.is_file())
    assert names == sorted(
        each.relative_to(tmp_path / "stopped") for each in (tmp_path / "stopped").rglob("*") if each.is_file()
    )
    for name in names:
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "stopped" / name).read_bytes()


def test_frames_of_a_run_that_was_stopped_before_its_index_do_not_stay(tmp_path: Path, monkeypatch):
    path, begun = public_set(tmp_path, FORCES_N), []

    def stops(ledger, index):
        if begun:  # the first shard has its name, and no index lists it yet
            raise KeyboardInterrupt
        begun.append(index)
        ledger.place(writing.FOLDER.index, sealed(index.model_dump(mode="json")))

    with monkeypatch.context() as patch:
        patch.setattr(type(writing.FOLDER), "write_index", lambda _, ledger, index: stops(ledger, index))
        with pytest.raises(KeyboardInterrupt):
            write_real(load_real(path), tmp_path / "set")
    frames = written(path, tmp_path / "set", "frames.rotate_deg=180")
    assert np.array_equal(frames[4]["image"], pressed(0.4, 2)[::-1, ::-1])
    assert verify_dataset(tmp_path / "set").problems == []


def test_episode_whose_rows_no_frame_has_is_none(tmp_path: Path):
    forces = [0.0, 0.0, 0.5, 1.0]
    video(tmp_path / "press.mkv", [pressed(force, number) for number, force in enumerate(forces)], [0, 0.1, 0.2, 0.3])
    rows = [{"t": 0.1 * step, "f": (*forces, 0, 0, 0)[step], "press": "b" if step > 3 else "a"} for step in range(7)]
    write_csv(tmp_path / "force.csv", rows)
    path = describe(
        tmp_path, 'frames = "press.mkv"', 'labels = "force.csv"',
        top=["most_gap_s = 0.05", 'columns = {time_s = "t", force_n = "f", episode = "press"}'],
    )  # fmt: skip
    assert written(path, tmp_path / "set").column("episode").tolist() == [0] * 4
    assert verify_dataset(tmp_path / "set").problems == []


def test_label_says_which_frames_of_a_video_are_references(tmp_path: Path):
    video(tmp_path / "press.mkv", [pressed(force, 0) for force in (0, 0, 0.5)], [0, 0.1, 0.2])
    write_csv(
        tmp_path / "force.csv", [{"t": 0.1 * step, "f": 0.5 * (step > 1), "free": int(step < 2)} for step in range(3)]
    )
    path = describe(
        tmp_path, 'frames = "press.mkv"', 'labels = "force.csv"',
        top=['columns = {time_s = "t", force_n = "f", is_reference = "free"}'],
    )  # fmt: skip
    assert written(path, tmp_path / "set").column("is_reference").tolist() == [True, True, False]


def test_licence_of_any_words_leaves_the_card_readable(tmp_path: Path):
    datasets = pytest.importorskip("datasets")
    write_real(load_real(public_set(tmp_path, FORCES_N), ["license=Creative Commons: BY 4.0"]), tmp_path / "set")
    assert len(datasets.load_dataset(str(tmp_path / "set"), split="train", cache_dir=str(tmp_path / "cache"))) == 6


def test_frame_of_another_size_is_told_also_when_a_run_goes_on(tmp_path: Path, monkeypatch):
    public_set(tmp_path, FORCES_N)
    rows = [
        {"file": f"{number:04d}.png", "press": "ab"[number > 4], "fz": force} for number, force in enumerate(FORCES_N)
    ]
    write_csv(tmp_path / "labels.csv", rows)
    path = describe(
        tmp_path, 'frames = "images"', 'labels = "labels.csv"',
        top=['columns = {image = "file", episode = "press", force_n = "fz"}'],
    )  # fmt: skip
    save(tmp_path / "images" / "0005.png", untouched()[:50])
    monkeypatch.setattr("magicsim.dataset.real.sequence.SAMPLED", 1)  # which the look at some frames passes by
    for resume in (False, True):
        with pytest.raises(FrameError, match="has 80 x 50 pixels, those before it 80 x 60"):
            write_real(load_real(path), tmp_path / "set", resume=resume)


def test_other_frames_do_not_go_on_with_a_dataset(tmp_path: Path):
    path = public_set(tmp_path, FORCES_N)
    write_real(load_real(path), tmp_path / "set")
    with pytest.raises(OutputError, match="of other frames or of another description"):
        write_real(load_real(path, ["frames.mirror=true"]), tmp_path / "set", resume=True)


def test_frames_of_equal_size_and_other_content_do_not_go_on_with_it(tmp_path: Path):
    described = public_set(tmp_path, FORCES_N)
    frame = tmp_path / "images" / "0005.png"
    content = frame.read_bytes()
    frame.write_bytes(content + b"a")  # behind its end
    write_real(load_real(described), tmp_path / "set")
    frame.write_bytes(content + b"b")
    with pytest.raises(OutputError, match=r"holds a dataset of other frames"):
        write_real(load_real(described), tmp_path / "set", resume=True)


def test_dataset_of_other_code_is_not_gone_on_with(tmp_path: Path, monkeypatch):
    described, known = public_set(tmp_path, FORCES_N), writing.versions()
    write_real(load_real(described), tmp_path / "set")
    monkeypatch.setattr(writing, "versions", lambda: known | {"sources": "0123456789abcdef"})
    with pytest.raises(OutputError, match=r"was begun with another version of sources: its results would differ"):
        write_real(load_real(described), tmp_path / "set", resume=True)


def test_folder_of_somebody_else_is_left_alone(tmp_path: Path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear", encoding="utf-8")
    with pytest.raises(OutputError, match=r"letter.txt"):
        write_real(load_real(public_set(tmp_path, FORCES_N)), tmp_path / "mine")


def test_frame_of_another_size_is_told_with_what_to_set(tmp_path: Path):
    path = public_set(tmp_path, FORCES_N)
    save(tmp_path / "images" / "0004.png", untouched()[:50])
    with pytest.raises(
        FrameError, match=r"has 80 x 50 pixels, those before it 80 x 60; set frames.size_px = \[80, 60\]"
    ):
        write_real(load_real(path), tmp_path / "set")


@pytest.mark.parametrize(
    ("recording", "said"),
    [
        (
            ['frames = "none"'],
            r"recordings\[0\].frames = '.*none' is not allowed: must be a folder of images or a video",
        ),
        (['frames = "images"', 'labels = "bad.csv"'], "line 2: image 'x.png' is not in folder"),
        (['frames = "images"', 'labels = "labels.csv"', 'untouched = "none"'], r"recordings\[0\].untouched = "),
        (['frames = "images"', 'labels = "labels.csv"', "untouched_below_n = 0.0"], "the least force is 0 N"),
        (['frames = "images"', "untouched_below_n = 1.0"], "needs a folder of images and labels with columns.force_n"),
    ],
)
def test_what_is_not_there_is_named_by_its_field(tmp_path: Path, recording: list[str], said: str):
    public_set(tmp_path, FORCES_N)
    write_csv(tmp_path / "bad.csv", [{"image_name": "x.png", "fx": 0, "fy": 0, "fz": 0}])
    with pytest.raises(ConfigError, match=said):
        write_real(load_real(describe(tmp_path, *recording)), tmp_path / "set")
    assert not (tmp_path / "set").exists()


def test_png_keeps_the_order_of_colours(tmp_path: Path):
    write_real(load_real(public_set(tmp_path, FORCES_N)), tmp_path / "set")
    source = open_dataset(tmp_path / "set")
    table = next(source.episodes(source.shards("train")[0]))
    assert np.array_equal(decoded(table["image"][0].as_py()), untouched(0))
