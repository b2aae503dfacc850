"""Frames by number are those of the shards; splits keep what belongs together."""

import pickle
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.dataset.frames import FrameTable, open_frames
from magicsim.errors import ConfigError, OutputError

from .fakes import decoded


@pytest.fixture
def frames(whole: Path, tmp_path: Path) -> FrameTable:
    return open_frames(whole, keep=tmp_path / "frames")


@pytest.fixture
def rows(whole: Path) -> list[dict]:
    """Rows of all shards, splits and files in order."""
    return [
        row for path in sorted((whole / "data").glob("*.parquet")) for row in pq.ParquetFile(path).read().to_pylist()
    ]


def test_how_a_frame_was_made_is_no_label(frames: FrameTable, whole: Path, tmp_path: Path):
    assert not [each.name for each in frames.columns if each.name.endswith("_way")]
    asked = open_frames(whole, ["light_way", "image_way"], keep=tmp_path / "ways")
    assert set(asked[0]) == {"light_way", "image_way"}


def test_every_row_comes_decoded(frames: FrameTable, rows: list[dict]):
    assert len(frames) == len(rows)
    for number in (3, 0, len(rows) - 1):
        mine, row = frames[number], rows[number]
        np.testing.assert_array_equal(mine["image"], decoded(row["image"]))
        np.testing.assert_array_equal(mine["contact_mask"], decoded(row["contact_mask"]) > 0)
        assert mine["image"].shape == (32, 24, 3)
        assert mine["force_n"].tolist() == row["force_n"]
        assert (mine["episode"], mine["step"]) == (row["episode"], row["step"])
        assert np.isnan(mine["gap_mm"])
    assert len(list(frames)) == len(rows)
    with pytest.raises(IndexError):
        frames[len(rows)]


def test_columns_are_those_asked_for(whole: Path, tmp_path: Path, rows: list[dict]):
    some = open_frames(whole, ["depth_map_mm", "time_s"], keep=tmp_path)
    assert set(some[0]) == {"depth_map_mm", "time_s"}
    np.testing.assert_array_equal(some[2]["depth_map_mm"], np.array(rows[2]["depth_map_mm"], np.float32))
    assert some.column("time_s").tolist() == [row["time_s"] for row in rows]
    assert some.split_by("episode", {"one": 1, "two": 1})
    with pytest.raises(ConfigError, match=r"unknown column 'depth_map'.*did you mean 'depth_map_mm'"):
        open_frames(whole, ["depth_map"], keep=tmp_path)
    with pytest.raises(ConfigError, match="unknown plain column 'depth_map_mm'"):
        some.column("depth_map_mm")


def test_stored_splits_are_those_of_the_files(frames: FrameTable, rows: list[dict]):
    parts = {name: frames.split(name) for name in set(frames.split_of.tolist())}
    assert sum(len(part) for part in parts.values()) == len(rows)
    episodes = [set(part.column("episode").tolist()) for part in parts.values()]
    assert sum(map(len, episodes)) == len(set.union(*episodes))
    with pytest.raises(ConfigError, match="unknown split 'tset'"):
        frames.split("tset")


@pytest.mark.parametrize(("group", "column"), [("episode", "episode"), ("unit", "sensor")])
def test_splits_share_no_group(frames: FrameTable, group: str, column: str):
    parts = frames.split_by(group, {"train": 0.7, "test": 0.3}, seed=1)
    train, test = (set(part.column(column).tolist()) for part in parts.values())
    assert train
    assert test
    assert not train & test
    assert sum(len(part) for part in parts.values()) == len(frames)
    again = frames.split_by(group, {"train": 0.7, "test": 0.3}, seed=1)
    assert again["test"].rows.tolist() == parts["test"].rows.tolist()


def test_small_share_still_gets_a_group_and_too_many_splits_are_refused(frames: FrameTable):
    parts = frames.split_by("unit", {"train": 0.98, "validation": 0.01, "test": 0.01})
    assert all(len(part) for part in parts.values())
    parts = frames.split_by("episode", {"train": 0.5, "validation": 0.01, "test": 0.49}, seed=3)  # of eleven
    assert [len(set(part.column("episode").tolist())) for part in parts.values()] == [6, 1, 4]
    with pytest.raises(ConfigError, match="4 groups by unit for 5 splits"):
        frames.split_by("unit", dict.fromkeys("abcde", 1.0))
    with pytest.raises(ConfigError, match="must be weights above 0"):
        frames.split_by("unit", {"train": 1.0, "test": 0.0})
    with pytest.raises(ConfigError, match="unknown group 'sensor'; available: episode, object, unit"):
        frames.split_by("sensor", {"train": 1.0})


def test_another_process_maps_the_same_copy(frames: FrameTable):
    there = pickle.loads(pickle.dumps(frames.where(np.arange(len(frames)) % 2 == 0)))
    np.testing.assert_array_equal(there[1]["image"], frames[2]["image"])
    assert len(pickle.dumps(frames)) < 100_000


def test_copy_is_made_once_and_anew_for_another_dataset(whole: Path, tmp_path: Path):
    first = open_frames(whole, keep=tmp_path).path
    made = first.stat().st_ino
    assert open_frames(whole, keep=tmp_path).path.stat().st_ino == made
    assert open_frames(whole, ["image"], keep=tmp_path).path != first
    assert [path.suffix for path in tmp_path.iterdir()] == [".arrow", ".arrow"]


def test_folder_without_a_dataset_is_refused(tmp_path: Path):
    with pytest.raises(OutputError, match="holds no dataset"):
        open_frames(tmp_path)


def test_tensors_are_what_loaders_batch(whole: Path, tmp_path: Path):
    torch = pytest.importorskip("torch")
    from magicsim.dataset.torch import TouchDataset

    frames = open_frames(whole, keep=tmp_path)
    samples = TouchDataset(frames)
    batch = next(iter(torch.utils.data.DataLoader(samples, batch_size=4)))
    assert batch["image"].shape == (4, 3, 32, 24)
    assert batch["image"].dtype == torch.uint8
    assert batch["contact_mask"].dtype == batch["contact"].dtype == torch.bool
    assert batch["force_n"].shape == (4, 3)
    assert batch["force_n"].dtype == batch["depth_mm"].dtype == torch.float32
    assert batch["episode"].dtype == torch.int64
    np.testing.assert_array_equal(batch["image"][2].numpy().transpose(1, 2, 0), frames[2]["image"])
    assert TouchDataset(frames, transform=lambda sample: sample["step"])[1] == 1


def test_without_torch_a_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    import sys

    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delitem(sys.modules, "magicsim.dataset.torch", raising=False)
    with pytest.raises(ConfigError, match=r"pip install 'magicsim\[torch\]'"):
        import magicsim.dataset.torch  # noqa: F401
