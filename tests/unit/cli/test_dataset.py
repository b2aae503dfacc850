from pathlib import Path

import pytest
from dataset.conftest import in_process  # noqa: F401 - a fixture
from dataset.fakes import FAILING, FAKE, FOLDER, SMALL

from .conftest import Shell

RECIPE = [str(FOLDER / "small.toml"), "--workers", "1", *(part for each in SMALL for part in ("--set", each))]


@pytest.fixture(autouse=True)
def without_rendering(monkeypatch: pytest.MonkeyPatch, in_process: None) -> None:  # noqa: F811
    monkeypatch.setattr("magicsim.dataset.generate.Work", lambda **_: FAKE)


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
    lines = done.err.splitlines()
    assert "drawing episodes" in lines[0]
    assert "frames to simulate" in lines[1]
    assert "MB that are free" in lines[1]
    assert lines[2].startswith("of these 1 processes that start")
    assert all(name in lines[2] for name in ("untouched images of 2 units", "frames of sphere", "writing"))
    assert lines[3].startswith("most is ")
    assert "%); shorter by " in lines[3]
    assert any("the untouched image of the first unit" in line for line in lines[4:])
    assert "frames/s, 0 failed" in lines[-1]


def test_dataset_goes_on_by_the_recipe_in_its_folder_and_says_what_it_keeps(shell: Shell):
    assert "recipe is missing" in shell.refusal("dataset", "--out", "set")
    assert "recipe is missing" in shell.refusal("dataset", "--out", "set", "--resume")
    found = shell.json("dataset", *RECIPE, "--out", "set")
    done = shell("dataset", "--out", "set", "--resume", "--workers", "1", "--set", "episodes=8")
    assert done.code == 0
    assert "5 of 8 episodes kept" in done.err.splitlines()
    assert shell.json("dataset", "--out", "set", "--resume", "--workers", "1")["samples"] > found["samples"]
    said = shell.refusal("dataset", "--out", "set", "--resume", "--set", "references=3", "--set", "render.samples=4")
    assert "holds a dataset of another recipe, which differs in references, render.samples; without RECIPE" in said


def test_why_an_episode_has_no_rows_is_told(shell: Shell, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setenv("FAKE_CRASH", str(tmp_path / "none"))
    monkeypatch.setattr("magicsim.dataset.generate.Work", lambda **_: FAILING)
    done = shell("dataset", *RECIPE, "--out", "set")
    assert done.code == 0
    last = done.err.splitlines()[-1]
    assert last == "1 episodes have no rows; episode 1: the deformation did not reach a valid equilibrium"


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
