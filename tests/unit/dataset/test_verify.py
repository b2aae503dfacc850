import json
import random
import resource
import shutil
import signal
from pathlib import Path

import pytest

from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.manifest import CONFIG, MANIFEST
from magicsim.dataset.preview import write_preview
from magicsim.dataset.verify import verify_dataset
from magicsim.errors import OutputError
from magicsim.folder.listing import sealed
from magicsim.workers.attempt import Failure, FailureKind, Work
from magicsim.workers.run_folder import ERRORS, changed_lines, log_failures

from .fakes import loose_rows, small_recipe


@pytest.fixture
def copy(whole: Path, tmp_path: Path) -> Path:
    return shutil.copytree(whole, tmp_path / "set")


def test_dataset_as_it_was_written_has_no_problems(whole: Path):
    found = verify_dataset(whole)
    assert (found.problems, found.complete, found.failed) == ([], True, 0)
    assert found.samples > 40


@pytest.mark.parametrize("quality", ["full", "control"])
def test_forces_are_balanced_as_well_as_the_recipes_solver_has_them(tmp_path: Path, in_process: None, quality: str):
    recipe = small_recipe("episodes=2", f"contact.quality={quality}")
    generate_dataset(recipe, tmp_path / "set", simulator=Work(function=loose_rows, prepare=None))
    problems = {each.partition(": ")[2] for each in verify_dataset(tmp_path / "set").problems}
    assert problems == ({"holds rows whose force is not finite or not balanced"} if quality == "full" else set())


@pytest.mark.parametrize("seed", range(6))
def test_flipped_bit_is_found_in_every_file(copy: Path, seed: int):
    chance = random.Random(seed)
    for path in [path for path in copy.rglob("*") if path.is_file() and path.name != MANIFEST]:
        before = path.read_bytes()
        place = chance.randrange(len(before))
        path.write_bytes(before[:place] + bytes([before[place] ^ (1 << chance.randrange(8))]) + before[place + 1 :])
        found = {problem.partition(":")[0] for problem in verify_dataset(copy).problems}
        # Another number in the recipe contradicts the manifest as well.
        also = {MANIFEST} if path.name == CONFIG else set()
        assert {path.relative_to(copy).as_posix()} <= found <= {path.relative_to(copy).as_posix()} | also
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


@pytest.mark.parametrize("seed", range(40))
def test_flipped_bit_in_the_manifest_is_told(copy: Path, seed: int):
    content, place = bytearray((copy / MANIFEST).read_bytes()), random.Random(seed)
    content[place.randrange(len(content))] ^= 1 << place.randrange(8)
    (copy / MANIFEST).write_bytes(content)
    try:
        problems = verify_dataset(copy).problems
    except OutputError as error:
        problems = [str(error)]
    assert any(MANIFEST in problem for problem in problems)


def test_newline_at_the_end_of_the_manifest_is_told(copy: Path):
    (copy / MANIFEST).write_bytes((copy / MANIFEST).read_bytes() + b"\n")
    assert verify_dataset(copy).problems == [f"{MANIFEST}: changed since it was written (its own SHA-256 differs)"]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"seed": 99}, "seed = 99 is not that of config.toml"),
        ({"episodes": 12}, "episodes = 12 is not that of config.toml"),
        ({"is_complete": False}, "says that the dataset is not complete"),
        ({"failed": [{"episode": 2, "kind": "refused", "message": "no"}]}, "says that the dataset is complete"),
        ({"config_hash": "0" * 64}, "config_hash = 000"),
        ({"rows": 3}, "rows = 3 is not the sum"),
    ],
)
def test_manifest_that_was_forged_with_its_hash_contradicts_the_recipe(copy: Path, change: dict, told: str):
    """Whoever also makes a new hash is noticed by what else is known."""
    values = json.loads((copy / MANIFEST).read_text())
    (copy / MANIFEST).write_bytes(sealed(values | change))
    assert any(told in problem for problem in verify_dataset(copy).problems)


def test_split_of_a_shard_that_was_forged_contradicts_the_recipe(copy: Path):
    values = json.loads((copy / MANIFEST).read_text())
    values["shards"][0]["split"] = "test" if values["shards"][0]["split"] != "test" else "train"
    (copy / MANIFEST).write_bytes(sealed(values))
    assert any("is no shard of the recipe's" in problem for problem in verify_dataset(copy).problems)


@pytest.mark.parametrize("name", ["../other.parquet", "/etc/passwd", "data/../../x", ""])
def test_path_that_leads_out_of_the_folder_is_refused(copy: Path, name: str):
    values = json.loads((copy / MANIFEST).read_text())
    values["shards"][0]["file"] = name
    (copy / MANIFEST).write_bytes(sealed(values))
    with pytest.raises(OutputError, match="must be a path below the dataset's folder"):
        verify_dataset(copy)


STRANGERS = (
    "notes.txt",
    ".hidden",
    "data/sub/x.parquet",
    "data/train-00099.parquet",
    "sub/a/b",
    ".work/a",
    "data/.x.tmp",
)


@pytest.mark.parametrize("name", STRANGERS)
def test_every_additional_file_is_told(copy: Path, name: str):
    (copy / name).parent.mkdir(parents=True, exist_ok=True)
    (copy / name).write_text("mine")
    assert verify_dataset(copy).problems == [f"{name}: not in the manifest"]


def test_changed_log_and_preview_are_told(copy: Path):
    log_failures(copy, "episode", 3, (Failure(kind=FailureKind.CRASH, message="its process ended"),) * 2)
    write_preview(copy, b"picture", {"samples": 4})
    write_preview(copy, b"another picture", {"samples": 4})
    assert not verify_dataset(copy).problems
    text = (copy / ERRORS).read_text()
    (copy / ERRORS).write_text(text.replace("crash", "crush", 1))
    (copy / "preview.png").write_bytes(b"mine")
    assert verify_dataset(copy).problems == [
        f"{ERRORS}: line 1 has changed since it was written", "preview.png: changed since it was written",
    ]  # fmt: skip
    with pytest.raises(OutputError, match=r"holds 'preview\.png', not as magicsim wrote it"):
        write_preview(copy, b"third picture", {})
    assert (copy / "preview.png").read_bytes() == b"mine"


def test_full_disk_leaves_no_line_of_the_log_that_counts_as_changed(tmp_path: Path):
    failures = (Failure(kind=FailureKind.ERROR, message="no", traceback="line\n" * 2000),)
    log_failures(tmp_path, "episode", 1, failures)
    limits, before = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, ((tmp_path / ERRORS).stat().st_size + 100, limits[1]))
    try:
        with pytest.raises(OSError, match="No space left"):
            log_failures(tmp_path, "episode", 2, failures)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    log_failures(tmp_path, "episode", 3, failures)
    assert changed_lines(tmp_path) == []
    assert len((tmp_path / ERRORS).read_bytes().splitlines()) == 2


def test_folder_without_a_readable_manifest_is_refused(copy: Path, tmp_path: Path):
    with pytest.raises(OutputError, match=r"holds no dataset: manifest\.json is missing"):
        verify_dataset(tmp_path)
    for text in ("{", "[]", '{"schema_version": 9}'):
        (copy / MANIFEST).write_text(text)
        with pytest.raises(OutputError, match="is not an index of a dataset"):
            verify_dataset(copy)


def test_rows_of_other_sources_than_the_manifest_says_are_told(copy: Path):
    manifest = json.loads((copy / MANIFEST).read_text())
    here = manifest["versions"]["sources"]
    assert f"sources {here}" in verify_dataset(copy).made_by
    (copy / MANIFEST).write_bytes(
        sealed(manifest | {"versions": manifest["versions"] | {"sources": "0123456789abcdef"}})
    )
    line = f"holds rows that other code made than the manifest says: version sources {here}"
    assert [each.partition(": ")[2] for each in verify_dataset(copy).problems] == [line] * len(manifest["shards"])


def test_dataset_that_does_not_say_its_sources_is_of_unknown_code(copy: Path):
    manifest = json.loads((copy / MANIFEST).read_text())
    del manifest["versions"]["sources"]
    (copy / MANIFEST).write_bytes(sealed(manifest))
    assert verify_dataset(copy).made_by == "unknown code"
