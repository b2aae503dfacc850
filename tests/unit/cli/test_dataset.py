from pathlib import Path

import pytest
from dataset.conftest import in_process  # noqa: F401 - a fixture
from dataset.fakes import FAKE, FOLDER, SMALL

from .conftest import Shell

RECIPE = [str(FOLDER / "small.toml"), "--workers", "1", *(part for each in SMALL for part in ("--set", each))]


@pytest.fixture(autouse=True)
def without_rendering(monkeypatch: pytest.MonkeyPatch, in_process: None) -> None:  # noqa: F811
    monkeypatch.setattr("magicsim.dataset.generate.Simulator", lambda: FAKE)


def test_dataset_prints_the_contract_and_can_be_verified_and_exported(shell: Shell, tmp_path: Path):
    found = shell.json("dataset", *RECIPE, "--out", "set")
    assert {"samples", "shards", "failed", "seconds"} <= set(found)
    assert found["failed"] == 0
    verified = shell.json("dataset", "verify", "set")
    assert (verified["samples"], verified["shards"]) == (found["samples"], found["shards"])
    assert verified["problems"] == []
    exported = shell.json("dataset", "export", "set", "--format", "webdataset", "--out", "tars")
    assert (exported["samples"], exported["files"]) == (found["samples"], found["shards"])
    assert "holds a dataset already; --resume goes on" in shell.refusal("dataset", *RECIPE, "--out", "set")
    grown = shell.json("dataset", *RECIPE, "--out", "set", "--resume", "--set", "episodes=8")
    assert grown["samples"] > found["samples"]
    assert {path.name for path in tmp_path.iterdir()} == {"set", "tars"}


def test_dataset_says_before_and_while_it_works_what_it_will_take(shell: Shell):
    done = shell("dataset", *RECIPE, "--out", "set")
    assert "frames to simulate" in done.err.splitlines()[0]
    assert "MB that are free" in done.err.splitlines()[0]
    assert "frames/s, 0 failed" in done.err.splitlines()[-1]


def test_damage_is_listed_and_the_exit_code_is_1(shell: Shell, tmp_path: Path):
    shell.json("dataset", *RECIPE, "--out", "set")
    shard = next((tmp_path / "set" / "data").glob("*.parquet"))
    content = bytearray(shard.read_bytes())
    content[100] ^= 4
    shard.write_bytes(content)
    done = shell("dataset", "verify", "set")
    assert done.code == 1
    assert f"data/{shard.name}: changed since it was written" in done.out


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["dataset", "verify", "set", "--set", "a=1"], "--set a=1 is not allowed with dataset verify"),
        (["dataset", *RECIPE, "--out", "set", "--preview", "0"], "preview = 0 is not allowed"),
        (["dataset", *RECIPE, "--out", "notes.txt"], "output folder 'notes.txt' is a file"),
        (["dataset", *RECIPE, "--out", "notes.txt", "--preview", "2"], "output folder 'notes.txt' is a file"),
        (["dataset", *RECIPE, "--out", "."], "output folder '.' holds other files"),
        (["dataset", "export", ".", "--format", "hdf5", "--out", "x"], "'.' holds no dataset"),
        (["dataset", "export", ".", "--format", "npz", "--out", "x"], '"npz"'),
        (["dataset", *RECIPE, "--out", "set", "--set", "objects=[{kind='sphere',radius_mm=-1.0}]"], "radius_mm = -1"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(shell: Shell, tmp_path: Path, arguments: list[str], named: str):
    (tmp_path / "notes.txt").touch()
    assert named in shell.refusal(*arguments)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
