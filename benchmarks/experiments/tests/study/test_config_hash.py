"""Hashes of studies follow the content of the files that they name."""

import hashlib
import json
from pathlib import Path

import numpy as np
from PIL import Image

from magicsim_experiments.study.study_file import load_study


def room(path: Path, grey: int) -> Path:
    Image.fromarray(np.full((4, 8, 3), grey, np.uint8)).save(path)
    return path


def test_hash_without_files_is_that_of_the_json_alone():
    study = load_study("manufacturing", quick=True).config
    data = json.dumps(study.model_dump(mode="json", exclude={"timeout_s"}), sort_keys=True)
    assert study.config_hash() == hashlib.sha256(data.encode()).hexdigest()


def test_picture_of_another_room_under_the_same_name_gives_another_hash(tmp_path: Path):
    settings = (f"rig.room='{room(tmp_path / 'room.png', 10)}'", "rig.ambient=[0.1,0.1,0.1]")
    before = load_study("manufacturing", settings, quick=True).config.config_hash()
    room(tmp_path / "room.png", 200)
    assert load_study("manufacturing", settings, quick=True).config.config_hash() != before
