"""What is kept has a size; the file that was asked for the longest ago goes first, and nothing of anybody else's."""

import os
from pathlib import Path

import pytest

from magicsim.cli.doctor import examine
from magicsim.errors import OutputError
from magicsim.evaluation import take as takes
from magicsim.folder import kept
from magicsim.folder.kept import KeptFiles, cache_folder, frames_folder, kept_copies, kept_takes
from magicsim.light.records.untouched import default_store


def written(folder: Path, names: list[str], size: int = 100) -> list[Path]:
    """Files of a size, one second after the other."""
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        (folder / name).write_bytes(b"x" * size)
        os.utime(folder / name, (1e9 + number, 1e9 + number))
    return [folder / name for name in names]


def test_oldest_files_go_first_and_asking_makes_one_the_newest(tmp_path: Path):
    first, second, third = written(tmp_path, ["a.bin", "b.bin", "c.bin"])
    (tmp_path / "notes.txt").write_bytes(b"x" * 1000)
    files = KeptFiles(folder=tmp_path, pattern=r"[a-z]\.bin", most_bytes=200)
    files.touch(first)
    files.shrink()
    assert files.files() == [third, first]
    assert (files.size_bytes(), second.exists(), (tmp_path / "notes.txt").exists()) == (200, False, True)
    assert files.clear() == 2
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_newest_file_stays_however_large_it_is(tmp_path: Path):
    (path,) = written(tmp_path, ["a.bin"])
    KeptFiles(folder=tmp_path, pattern=r".*\.bin", most_bytes=1).shrink()
    assert path.exists()


def test_doctor_tells_and_clears_takes_and_copies_of_frames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(kept.FRAMES_VARIABLE, str(tmp_path / "frames"))
    monkeypatch.setattr("magicsim.cli.doctor.probe_llvm", lambda _: None)
    written(tmp_path / "magicsim-takes", [f"{1:024x}.npz", "mine.npz"])
    written(tmp_path / "frames", [f"{1:032x}.arrow", "mine.arrow"])
    found = examine()
    assert (found.takes_bytes, found.frames_bytes) == (100, 100)
    found = examine(clear_cache=True)
    assert (found.takes_bytes, found.frames_bytes) == (0, 0)
    assert sorted(path.name for path in tmp_path.rglob("mine.*")) == ["mine.arrow", "mine.npz"]


def test_names_are_those_of_takes_and_copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from dataset.fakes import FAKE, small_recipe

    from magicsim.dataset.frames import open_frames
    from magicsim.dataset.generate import generate_dataset
    from magicsim.scenes.scene import load_scene
    from magicsim.workers.attempt import WorkerOptions

    monkeypatch.setattr(takes, "film_take", lambda _: takes.Take(**dict.fromkeys(takes.Take.__slots__, 0)))
    takes.cached_take(load_scene("pressed"), tmp_path / "takes")
    generate_dataset(small_recipe("episodes=1"), tmp_path / "set", options=WorkerOptions(workers=1), simulator=FAKE)
    open_frames(tmp_path / "set", keep=tmp_path / "frames")
    assert len(kept_takes(tmp_path / "takes").files()) == len(list((tmp_path / "takes").iterdir())) == 1
    assert len(kept_copies(tmp_path / "frames").files()) == len(list((tmp_path / "frames").iterdir())) == 1


def test_without_a_home_folder_nothing_is_kept_and_copies_need_a_name(monkeypatch: pytest.MonkeyPatch):
    from magicsim.dataset.frames import _default_folder

    for name in ("HOME", "XDG_CACHE_HOME", "MAGICSIM_CACHE", kept.FRAMES_VARIABLE):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", lambda _: (_ for _ in ()).throw(KeyError("no such user")))
    assert (cache_folder(), frames_folder(), default_store()) == (None, None, None)
    with pytest.raises(OutputError, match="no home folder for a copy of the frames: name one with keep or MAGICSIM_FR"):
        _default_folder()
