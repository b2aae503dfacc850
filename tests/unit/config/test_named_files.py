"""Hashes of configurations follow the content of the files that they name, and without such files their JSON alone."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dataset.fakes import small_recipe
from PIL import Image
from sweep.fakes import small_sweep

from magicsim.config.named_files import config_digest, file_hashes, named_files
from magicsim.evaluation.take import take_key
from magicsim.folder.listing import sha256_of
from magicsim.scenes.scene import load_scene


def plain(data: object) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()


def room(path: Path, grey: int) -> Path:
    Image.fromarray(np.full((4, 8, 3), grey, np.uint8)).save(path)
    return path


def test_hash_without_files_is_that_of_the_json_alone():
    recipe = small_recipe()
    data = recipe.model_dump(mode="json", exclude={"episodes", "license", "timeout_s"})
    assert recipe.config_hash() == plain(data)
    sweep = small_sweep()
    assert sweep.config_hash() == plain(sweep.model_dump(mode="json", exclude={"timeout_s", "objectives", "search"}))
    assert not named_files(load_scene("demo").model_dump(mode="json"))


KEYS: dict[str, Callable[..., str]] = {
    "recipe": lambda *settings: small_recipe(*settings).config_hash(),
    "take": lambda *settings: take_key(load_scene("pressed", settings)),
    "sweep": lambda *settings: small_sweep(*settings).config_hash(),
}


@pytest.mark.parametrize("key", KEYS)
def test_picture_of_another_room_under_the_same_name_gives_another_hash(key: str, tmp_path: Path):
    settings = (f"rig.room='{room(tmp_path / 'room.png', 10)}'", "rig.ambient=[0.1,0.1,0.1]")
    before = KEYS[key](*settings)
    assert KEYS[key](*settings) == before
    room(tmp_path / "room.png", 200)
    assert KEYS[key](*settings) != before


def test_every_kind_of_file_is_found_wherever_it_stands(tmp_path: Path):
    for name in ("a.stl", "dots.png", "face.npy", "room.jpg", "design.toml"):
        (tmp_path / name).write_text(name)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder/b.ply").write_text("b")
    (tmp_path / "folder/notes.txt").write_text("n")
    data = {
        "objects": [{"kind": "mesh", "path": f"{tmp_path}/a.stl"}, {"kind": "mesh", "folder": f"{tmp_path}/folder"}],
        "design": {"markers": {"kind": "picture", "file": f"{tmp_path}/dots.png"},
                   "face": {"kind": "height_map", "file": f"{tmp_path}/face.npy"}},
        "rooms": [{"room": f"{tmp_path}/room.jpg"}, {"room": "office"}], "other": (f"{tmp_path}/design.toml",),
        "mesh": {"kind": "mesh", "path": f"{tmp_path}/gone.stl"}, "words": ["a.stl", {"path": f"{tmp_path}/a.stl"}],
    }  # fmt: skip
    found = file_hashes(data)
    names = ["a.stl", "design.toml", "dots.png", "face.npy", "folder/b.ply", "room.jpg"]
    assert found == {f"{tmp_path}/{name}": sha256_of(tmp_path / name) for name in names}
    for name in names:
        before = config_digest(data)
        (tmp_path / name).write_text("other")
        assert config_digest(data) != before
    (tmp_path / "folder/notes.txt").write_text("other")
    assert config_digest({"a": 1, "room": "office"}) == plain({"a": 1, "room": "office"})


def test_materials_of_a_mesh_and_files_of_a_named_toml_count(tmp_path: Path):
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\n")
    (tmp_path / "a.mtl").write_text("newmtl x\n  map_Kd -s 1 1 1 skin.png\n")
    (tmp_path / "skin.png").write_text("picture")
    (tmp_path / "ball.toml").write_text('kind = "mesh"\npath = "a.obj"\nagain = "ball.toml"\n')
    found = file_hashes({"item": f"{tmp_path}/ball.toml"})
    assert {Path(name).name for name in found} == {"a.obj", "a.mtl", "skin.png", "ball.toml"}
    (tmp_path / "ball.toml").write_text("no toml [")
    assert len(file_hashes({"item": f"{tmp_path}/ball.toml"})) == 1
