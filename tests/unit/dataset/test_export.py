"""Each layout is read back by its own library, where that is installed."""

import io
import json
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from magicsim.dataset.export.formats import export_dataset
from magicsim.dataset.export.source import open_dataset
from magicsim.errors import OutputError

from .fakes import decoded

READ_TARS = """
import json, sys, webdataset
samples = webdataset.WebDataset(sys.argv[1:], shardshuffle=False).decode("rgb8")
print(json.dumps([
    {"pixels": each["png"].tolist(), "force_n": each["json"]["force_n"],
     "moved": each["displacements_mm.npy"].shape} for each in samples
]))
"""
HF = "ignore::DeprecationWarning"


@pytest.fixture
def rows(whole: Path) -> dict[str, list[dict[str, object]]]:
    """Rows of the dataset by split, in order."""
    found: dict[str, list[dict[str, object]]] = {}
    for path in sorted((whole / "data").glob("*.parquet")):
        with pq.ParquetFile(path) as file:
            found.setdefault(path.name.split("-")[0], []).extend(file.read().to_pylist())
    return found


def test_hdf5_holds_every_column_of_every_row(whole: Path, tmp_path: Path, rows: dict):
    h5py = pytest.importorskip("h5py")
    found = export_dataset(whole, tmp_path / "h5", "hdf5")
    assert found.samples == sum(len(each) for each in rows.values())
    for split, expected in rows.items():
        with h5py.File(tmp_path / "h5" / f"{split}.h5") as file:
            for place, row in enumerate(expected):
                np.testing.assert_array_equal(file["image"][place], decoded(row["image"]))
                np.testing.assert_array_equal(file["contact_mask"][place], decoded(row["contact_mask"]))
                np.testing.assert_array_equal(file["depth_map_mm"][place], np.array(row["depth_map_mm"], np.float32))
                np.testing.assert_array_equal(file["torque_nmm"][place], row["torque_nmm"])
                assert file["path_kind"].asstr()[place] == row["path_kind"]
                assert file["episode"][place] == row["episode"]
                assert np.isnan(file["gap_mm"][place])
                moved = np.array(row["displacements_mm"], np.float32)
                np.testing.assert_array_equal(file["displacements_mm"][place][: len(moved)], moved)
            assert "[N]" in file["force_n"].attrs["description"]
            assert file.attrs["config_hash"] == open_dataset(whole).manifest.config_hash


def test_zarr_holds_every_column_of_every_row(whole: Path, tmp_path: Path, rows: dict):
    zarr = pytest.importorskip("zarr")
    export_dataset(whole, tmp_path / "store", "zarr")
    root = zarr.open_group(tmp_path / "store", mode="r")
    for split, expected in rows.items():
        group = root[split]
        assert group["image"].shape[0] == len(expected)
        for place, row in enumerate(expected):
            np.testing.assert_array_equal(group["image"][place], decoded(row["image"]))
            np.testing.assert_array_equal(group["force_n"][place], row["force_n"])
        assert group.attrs["texts"]["path_kind"] == [row["path_kind"] for row in expected]
        np.testing.assert_array_equal(group["step"][:], [row["step"] for row in expected])


def test_tar_members_share_their_samples_name(whole: Path, tmp_path: Path, rows: dict):
    export_dataset(whole, tmp_path / "tars", "webdataset")
    split, expected = next(iter(rows.items()))
    with tarfile.open(tmp_path / "tars" / f"{split}-000000.tar") as archive:
        names = archive.getnames()
        first = f"{expected[0]['episode']:08d}_{expected[0]['step']:04d}"
        assert [name for name in names if name.startswith(first)] == [
            f"{first}.png", f"{first}.mask.png", f"{first}.depth_map_mm.npy", f"{first}.displacements_mm.npy",
            f"{first}.json",
        ]  # fmt: skip
        depth = np.load(io.BytesIO(archive.extractfile(f"{first}.depth_map_mm.npy").read()))
    np.testing.assert_array_equal(depth, np.array(expected[0]["depth_map_mm"], np.float32))


def test_webdataset_reads_its_samples(whole: Path, tmp_path: Path, rows: dict):
    pytest.importorskip("webdataset")
    export_dataset(whole, tmp_path / "tars", "webdataset")
    for split, expected in rows.items():
        tars = [str(path) for path in sorted((tmp_path / "tars").glob(f"{split}-*.tar"))]
        # In a process of its own: the library leaves its files to the garbage collector.
        done = subprocess.run([sys.executable, "-c", READ_TARS, *tars], capture_output=True, text=True, check=True)
        samples = json.loads(done.stdout)
        assert len(samples) == len(expected)
        for sample, row in zip(samples, expected, strict=True):
            assert sample["pixels"] == decoded(row["image"]).tolist()
            assert sample["force_n"] == row["force_n"]
            assert sample["moved"] == list(np.shape(row["displacements_mm"]))


def test_lerobot_layout_agrees_with_itself_and_with_the_rows(whole: Path, tmp_path: Path, rows: dict):
    export_dataset(whole, tmp_path / "robot", "lerobot")
    root = tmp_path / "robot"
    info = json.loads((root / "meta" / "info.json").read_text())
    episodes = pq.read_table(root / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    tasks = pq.read_table(root / "meta" / "tasks.parquet").to_pylist()
    assert (info["codebase_version"], info["video_path"]) == ("v3.0", None)
    assert info["total_episodes"] == len(episodes) == 11
    assert info["total_frames"] == sum(len(each) for each in rows.values())
    ordered = [row for split in sorted(rows) for row in rows[split]]
    for episode in episodes:
        place = {"chunk_index": episode["data/chunk_index"], "file_index": episode["data/file_index"]}
        table = pq.read_table(root / info["data_path"].format(**place))
        assert set(table.column_names) == set(info["features"])
        mine = [row for row in table.to_pylist() if row["episode_index"] == episode["episode_index"]]
        assert [row["index"] for row in mine] == list(range(episode["dataset_from_index"], episode["dataset_to_index"]))
        for row in mine:
            source = ordered[row["index"]]
            assert row["observation.images.tactile"]["bytes"] == source["image"]["bytes"]
            assert row["observation.state"][3:6] == pytest.approx(source["torque_nmm"], rel=1e-6)
            assert tasks[row["task_index"]]["task"] == source["path_kind"] == episode["tasks"][0]
            assert row["timestamp"] == pytest.approx(row["frame_index"] / info["fps"])
    stats = json.loads((root / "meta" / "stats.json").read_text())
    pixels = np.stack([decoded(row["image"]) for row in ordered]) / 255
    np.testing.assert_allclose(np.ravel(stats["observation.images.tactile"]["mean"]), pixels.mean((0, 1, 2)))
    np.testing.assert_allclose(np.ravel(stats["observation.images.tactile"]["std"]), pixels.std((0, 1, 2)))
    assert np.shape(stats["observation.images.tactile"]["mean"]) == (3, 1, 1)


@pytest.mark.filterwarnings(HF)
def test_lerobot_files_are_read_by_the_library_that_lerobot_reads_them_with(whole: Path, tmp_path: Path):
    datasets = pytest.importorskip("datasets")
    pandas = pytest.importorskip("pandas")
    export_dataset(whole, tmp_path / "robot", "lerobot")
    files = [str(path) for path in sorted((tmp_path / "robot" / "data").rglob("*.parquet"))]
    frames = datasets.Dataset.from_parquet(files, cache_dir=str(tmp_path / "cache"))
    assert isinstance(frames.features["observation.images.tactile"], datasets.Image)
    assert frames[0]["observation.images.tactile"].size == (24, 32)
    tasks = pandas.read_parquet(tmp_path / "robot" / "meta" / "tasks.parquet")
    assert list(tasks.index) == ["flashlight", "touch"]
    assert list(tasks["task_index"]) == [0, 1]


@pytest.mark.filterwarnings(HF)
def test_hugging_face_reads_images_arrays_and_labels_with_their_types(whole: Path, tmp_path: Path, rows: dict):
    datasets = pytest.importorskip("datasets")
    loaded = datasets.load_dataset(str(whole), cache_dir=str(tmp_path))
    assert set(loaded) == set(rows)
    for split, expected in rows.items():
        frames = loaded[split]
        assert isinstance(frames.features["image"], datasets.Image)
        assert frames.features["depth_map_mm"] == datasets.Array2D(shape=(32, 24), dtype="float32")
        assert frames.features["force_n"].length == 3
        assert frames.features["contact"].dtype == "bool"
        assert len(frames) == len(expected)
        np.testing.assert_array_equal(np.asarray(frames[0]["image"]), decoded(expected[0]["image"]))
        arrays = frames.with_format("numpy")
        np.testing.assert_array_equal(arrays[0]["depth_map_mm"], np.array(expected[0]["depth_map_mm"], np.float32))
        assert arrays[0]["displacements_mm"].shape[1] == 3
    sensors = datasets.load_dataset(str(whole), "sensors", split="train", cache_dir=str(tmp_path))
    assert len(sensors) == 4
    assert json.loads(sensors[0]["design"])["footprint_mm"] == [12.0, 16.0]


def test_export_refuses_what_is_not_a_finished_dataset_or_a_target_that_exists(whole: Path, tmp_path: Path):
    with pytest.raises(OutputError, match="holds no dataset"):
        export_dataset(tmp_path, tmp_path / "out", "webdataset")
    with pytest.raises(OutputError, match="exists; name a new folder"):
        export_dataset(whole, tmp_path, "webdataset")
    assert list(tmp_path.iterdir()) == []


def test_rows_keep_their_schema_where_extension_types_are_registered(whole: Path):
    source = open_dataset(whole)
    shard = source.manifest.shards[0]
    for table in source.episodes(shard):
        assert table.schema.field("depth_map_mm").type == pa.list_(pa.list_(pa.float32()))


def read_mcap(path: Path) -> dict[str, list[tuple[int, object]]]:
    """Messages by topic, with their time [ns], as the library reads and decodes them."""
    reader = pytest.importorskip("mcap.reader")
    protobuf = pytest.importorskip("mcap_protobuf.decoder")
    found: dict[str, list[tuple[int, object]]] = {}
    with path.open("rb") as file:
        read = reader.make_reader(file, decoder_factories=[protobuf.DecoderFactory(), Json()])
        for _, channel, message, decoded in read.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


class Json:
    """Decodes what `mcap` leaves to its users."""

    def decoder_for(self, encoding: str, schema: object) -> object:
        del schema
        return json.loads if encoding == "json" else None


def test_mcap_holds_an_episode_a_file_on_one_clock(whole: Path, tmp_path: Path, rows: dict):
    pytest.importorskip("foxglove")
    found = export_dataset(whole, tmp_path / "logs", "mcap")
    assert found.files == 11
    split, expected = next(iter(rows.items()))
    episode = expected[0]["episode"]
    expected = [row for row in expected if row["episode"] == episode]
    topics = read_mcap(tmp_path / "logs" / split / f"episode-{episode:08d}.mcap")
    images, masks, truth = (topics[f"/tactile/{name}"] for name in ("image", "contact_mask", "truth"))
    times = [round(row["time_s"] * 1e9) for row in expected]
    assert [at for at, _ in images] == [at for at, _ in truth] == [at for at, _ in masks] == times
    for (at, image), (_, mask), (_, told), row in zip(images, masks, truth, expected, strict=True):
        assert (image.format, image.frame_id) == ("png", "camera")
        assert image.data == row["image"]["bytes"]
        assert mask.data == row["contact_mask"]["bytes"]
        assert image.timestamp.seconds * 10**9 + image.timestamp.nanos == at
        assert told["force_n"] == row["force_n"]
        assert told["gap_mm"] is None
    # What stands still comes once a second.
    still = topics["/tactile/calibration"]
    assert [at for at, _ in still] == [round(second * 1e9) for second in range(int(expected[-1]["time_s"]) + 1)]
    assert list(still[0][1].K) == expected[0]["camera_matrix"]
    assert (still[0][1].width, still[0][1].height) == (24, 32)


def test_mcap_transforms_are_in_metres_and_turn_as_the_rows_do(tmp_path: Path):
    pytest.importorskip("foxglove")
    from magicsim.dataset.export.mcap import write_mcap_episode

    turn = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]  # 90 degrees about z
    row = {
        "time_s": 0.25, "step": 1, "is_reference": False, "frame_class": "", "gap_mm": 2.0, "contact": False,
        "depth_mm": 0.0, "force_n": [0.0] * 3, "torque_nmm": [0.0] * 3, "contact_area_mm2": 0.0, "flashlight": False,
        "image": {"bytes": b"png"}, "contact_mask": None, "camera_matrix": [1.0] * 9, "camera_distortion": [0.0] * 5,
        "camera_position_mm": [0.0, 0.0, 30.0], "camera_rotation": [1.0, 0, 0, 0, -1.0, 0, 0, 0, -1.0],
        "object_position_mm": [1.0, 2.0, -7.0], "object_rotation": turn,
    }  # fmt: skip
    write_mcap_episode(tmp_path / "one.mcap", [row], size=(4, 3))
    topics = read_mcap(tmp_path / "one.mcap")
    [(at, message)] = topics["/tf"]
    camera, thing = message.transforms
    assert at == 250_000_000
    assert (camera.parent_frame_id, camera.child_frame_id, thing.child_frame_id) == ("sensor", "camera", "object")
    assert camera.translation.z == pytest.approx(0.03)
    assert (thing.translation.x, thing.translation.y) == pytest.approx((0.001, 0.002))
    assert (abs(camera.rotation.x), camera.rotation.w) == pytest.approx((1.0, 0.0), abs=1e-12)
    assert (thing.rotation.z, thing.rotation.w) == pytest.approx((0.5**0.5, 0.5**0.5))
    assert "/tactile/contact_mask" not in topics
