"""A run is the same run as long as the content of every file that it names is."""

from dataclasses import replace
from pathlib import Path

import pytest
import tomli_w
from PIL import Image

from magicsim.detectors.profile import load_profile, save_profile
from magicsim_experiments.task.growing import digest_of
from magicsim_experiments.task.running import GraspPlayer
from magicsim_experiments.task.settings import GraspConfig

from .test_running import ITEM


def room(path: Path, grey: int) -> None:
    Image.new("RGB", (64, 32), (grey, grey, grey)).save(path)


@pytest.fixture
def config(tmp_path: Path) -> GraspConfig:
    """A task of which everything is in files of the user's own."""
    (tmp_path / "ball.toml").write_text(ITEM)
    save_profile(load_profile("calibrated"), tmp_path / "mine.toml", comment="mine")
    room(tmp_path / "room.png", 100)
    names = {"room": "room.png", "detector": "mine.toml"}
    paths = {key: str(tmp_path / name) for key, name in names.items()}
    return GraspConfig(**paths, items=(str(tmp_path / "ball.toml"),), scene=("design.footprint_mm=[12,16]",))


def digest(config: GraspConfig) -> str:
    return digest_of(GraspPlayer(config).settings())


def test_same_files_make_the_same_run(config: GraspConfig):
    assert digest(config) == digest(config)


def test_other_content_under_the_same_name_makes_another_run(config: GraspConfig, tmp_path: Path):
    before = {digest(config)}
    profile = load_profile("calibrated")
    save_profile(replace(profile, tau_b=profile.tau_b + 1), tmp_path / "mine.toml", comment="mine")
    before.add(digest(config))
    (tmp_path / "ball.toml").write_text(ITEM.replace("mass_g = 20.0", "mass_g = 21.0"))
    before.add(digest(config))
    room(tmp_path / "room.png", 200)
    before.add(digest(config))
    assert len(before) == 4


def test_settings_that_are_written_hold_what_the_names_stand_for(config: GraspConfig, tmp_path: Path):
    settings = GraspPlayer(config).settings()
    content = settings["resolved"]
    assert content["profile"]["tau_b"] == load_profile("calibrated").tau_b
    assert content["items"][config.items[0]]["mass_g"] == 20.0
    assert content["fingers"]["design"]["footprint_mm"] == [12.0, 16.0]
    assert set(content["sha256"][config.items[0]]) == {(tmp_path / "room.png").as_posix()}
    tomli_w.dumps(settings)
