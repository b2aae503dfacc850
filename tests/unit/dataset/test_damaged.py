"""Files of a dataset that are not as they were written: refused by name, whoever opens them."""

import io
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from magicsim.dataset.export.formats import export_dataset
from magicsim.dataset.export.source import open_dataset
from magicsim.dataset.frames import open_frames
from magicsim.dataset.manifest import CONFIG, MANIFEST, SENSORS
from magicsim.dataset.shard import decoded_png
from magicsim.errors import OutputError
from magicsim.folder.listing import sealed, sha256_of

SHARD = "data/test-00000.parquet"
OTHER = "data/test-00001.parquet"


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:500])


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def swap(path: Path) -> None:
    path.write_bytes((path.parents[1] / OTHER).read_bytes())


DAMAGE: dict[str, Callable[[Path], object]] = {
    "missing": Path.unlink, "empty": lambda path: path.write_bytes(b""), "cut": cut, "swapped": swap,
    "flipped": flip,
}  # fmt: skip


@pytest.fixture
def copy(whole: Path, tmp_path: Path) -> Path:
    return shutil.copytree(whole, tmp_path / "set")


def list_anew(folder: Path, name: str, **changed: object) -> None:
    """Makes the manifest say of a shard what it is now."""
    manifest, path = json.loads((folder / MANIFEST).read_text()), folder / name
    entry = next(each for each in manifest["shards"] if each["file"] == name)
    entry |= {"sha256": sha256_of(path), "size": path.stat().st_size, **changed}
    (folder / MANIFEST).write_bytes(sealed(manifest))


def with_images(folder: Path, name: str, png: bytes) -> None:
    """Puts a picture in the place of the second of a shard, and the shard's new hash into the manifest."""
    with pq.ParquetFile(folder / name) as file:
        table = file.read()
    images = table["image"].combine_chunks()
    values = (images.storage if isinstance(images, pa.ExtensionArray) else images).to_pylist()
    values[1] = {"bytes": png, "path": None}
    kind = next(each.arrow for each in open_dataset(folder).columns if each.name == "image")
    pq.write_table(table.set_column(table.column_names.index("image"), "image", pa.array(values, kind)), folder / name)
    list_anew(folder, name)


@pytest.mark.parametrize("damage", DAMAGE)
def test_shard_that_is_not_as_it_was_written_is_refused_by_name(copy: Path, tmp_path: Path, damage: str):
    DAMAGE[damage](copy / SHARD)
    said = rf"set/{SHARD}' is (missing|not as it was written)"
    with pytest.raises(OutputError, match=said):
        open_frames(copy, keep=tmp_path / "frames")
    with pytest.raises(OutputError, match=said):
        export_dataset(copy, tmp_path / "out", "webdataset")
    assert not (tmp_path / "out").exists()
    assert not list((tmp_path / "frames").glob("*.arrow"))


def test_damaged_copy_of_a_dataset_does_not_reach_the_good_one(whole: Path, copy: Path, tmp_path: Path):
    flip(copy / SHARD)
    with pytest.raises(OutputError):
        open_frames(copy, ["step"], keep=tmp_path)
    good = open_frames(whole, ["step"], keep=tmp_path)
    assert len(good) == sum(1 for _ in good)


@pytest.mark.parametrize("damage", ["missing", "empty", "cut"])
def test_shard_is_asked_for_even_where_its_rows_were_copied_before(copy: Path, tmp_path: Path, damage: str):
    open_frames(copy, ["step"], keep=tmp_path / "frames")
    DAMAGE[damage](copy / SHARD)
    with pytest.raises(OutputError, match=rf"set/{SHARD}' is (missing|not as it was written)"):
        open_frames(copy, ["step"], keep=tmp_path / "frames")


def test_damaged_cached_copy_is_made_again(whole: Path, tmp_path: Path):
    first = open_frames(whole, ["step"], keep=tmp_path)
    steps = first.column("step").tolist()
    cut(first.path)
    assert open_frames(whole, ["step"], keep=tmp_path).column("step").tolist() == steps


@pytest.mark.parametrize("name", [CONFIG, SENSORS])
def test_file_beside_the_shards_that_has_changed_is_refused_by_name(copy: Path, tmp_path: Path, name: str):
    pytest.importorskip("h5py")
    flip(copy / name)
    with pytest.raises(OutputError, match=rf"set/{name}' is not as it was written"):
        export_dataset(copy, tmp_path / "out", "hdf5")


def test_rows_that_the_manifest_promises_must_be_there(copy: Path, tmp_path: Path):
    list_anew(copy, SHARD, episodes=[7000])
    with pytest.raises(OutputError, match=rf"set/{SHARD}' holds no row of episode 7000"):
        open_frames(copy, keep=tmp_path)
    list_anew(copy, SHARD, rows=3)
    with pytest.raises(OutputError, match=rf"set/{SHARD}' holds \d+ rows, and {MANIFEST} lists 3"):
        open_frames(copy, keep=tmp_path)
    shutil.copy(copy / SENSORS, copy / SHARD)
    list_anew(copy, SHARD)
    with pytest.raises(OutputError, match=rf"set/{SHARD}' does not hold the rows of this dataset: .*image"):
        open_frames(copy, keep=tmp_path)
    (copy / SHARD).write_bytes(b"PAR1")
    list_anew(copy, SHARD)
    with pytest.raises(OutputError, match=rf"set/{SHARD}' does not hold the rows of this dataset"):
        open_frames(copy, keep=tmp_path)


def test_picture_that_cannot_be_decoded_is_named_with_file_and_row(copy: Path, tmp_path: Path):
    pytest.importorskip("h5py")
    with_images(copy, SHARD, b"no picture")
    said = rf"set/{SHARD}': image of row 1 of episode \d+ is no PNG"
    for layout in ("hdf5", "lerobot"):
        with pytest.raises(OutputError, match=said):
            export_dataset(copy, tmp_path / "out", layout)
    frames = open_frames(copy, ["image"], keep=tmp_path)
    with pytest.raises(OutputError, match=r"arrow', a copy of a dataset: image of row 1 is no PNG"):
        frames.split("test")[1]
    assert frames[0]["image"].shape == (32, 24, 3)


def test_png_that_breaks_off_or_is_none_gives_no_pixels(whole: Path, capfd: pytest.CaptureFixture[str]):
    table = next(open_dataset(whole).episodes(open_dataset(whole).manifest.shards[0]))
    png = table["image"][0].as_py()["bytes"]
    assert decoded_png(png).shape == (32, 24, 3)
    other = io.BytesIO()
    from PIL import Image

    Image.new("RGB", (4, 4)).save(other, "JPEG")
    for bad in (b"", b"no", png[:-5], png[:300] + b"\0" + png[301:], other.getvalue(), None):
        assert decoded_png(bad) is None
    assert capfd.readouterr().err == ""


def test_export_into_the_dataset_is_refused(copy: Path):
    before = set(copy.rglob("*"))
    for place in (copy / "x", copy / "data" / "deep" / "x", copy):
        with pytest.raises(OutputError, match="inside of the dataset"):
            export_dataset(copy, place, "webdataset")
    assert set(copy.rglob("*")) == before
