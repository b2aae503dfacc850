import random
import shutil
from pathlib import Path

import pytest

from magicsim.dataset.manifest import MANIFEST
from magicsim.dataset.verify import verify_dataset
from magicsim.errors import OutputError


@pytest.fixture
def copy(whole: Path, tmp_path: Path) -> Path:
    return shutil.copytree(whole, tmp_path / "set")


def test_dataset_as_it_was_written_has_no_problems(whole: Path):
    found = verify_dataset(whole)
    assert (found.problems, found.complete, found.failed) == ([], True, 0)
    assert found.samples > 40


@pytest.mark.parametrize("seed", range(6))
def test_flipped_bit_is_found_in_every_file(copy: Path, seed: int):
    chance = random.Random(seed)
    for path in [path for path in copy.rglob("*") if path.is_file() and path.name != MANIFEST]:
        before = path.read_bytes()
        place = chance.randrange(len(before))
        path.write_bytes(before[:place] + bytes([before[place] ^ (1 << chance.randrange(8))]) + before[place + 1 :])
        assert [problem.partition(":")[0] for problem in verify_dataset(copy).problems] == [
            path.relative_to(copy).as_posix()
        ]
        path.write_bytes(before)


def test_missing_cut_and_foreign_files_are_named(copy: Path):
    shards = sorted((copy / "data").glob("*.parquet"))
    shards[0].unlink()
    shards[1].write_bytes(shards[1].read_bytes()[:-1])
    shutil.copy(shards[2], shards[2].with_name("train-00099.parquet"))
    (copy / "calibration.json").unlink()
    problems = verify_dataset(copy).problems
    assert f"data/{shards[0].name}: missing" in problems
    assert f"data/{shards[1].name}: changed since it was written (SHA-256 differs)" in problems
    assert "data/train-00099.parquet: not in the manifest" in problems
    assert "calibration.json: missing" in problems
    assert len(problems) == 4


def test_folder_without_a_readable_manifest_is_refused(copy: Path, tmp_path: Path):
    with pytest.raises(OutputError, match=r"holds no dataset: manifest\.json is missing"):
        verify_dataset(tmp_path)
    for text in ("{", "[]", '{"schema_version": 9}'):
        (copy / MANIFEST).write_text(text)
        with pytest.raises(OutputError, match="is not a manifest of magicsim"):
            verify_dataset(copy)
