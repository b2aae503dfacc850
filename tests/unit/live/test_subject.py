from pathlib import Path

import pytest

from magicsim.config.presets import find_preset
from magicsim.errors import ConfigError, PresetError
from magicsim.live.session import find_subject
from magicsim.scenes.scene import load_scene


def test_scene_is_itself():
    assert find_subject("pressed") == load_scene("pressed")


@pytest.mark.parametrize("name", ["uniform-block", str(find_preset("design", "uniform-block"))])
def test_design_takes_rig_and_object_of_a_standard_scene(name: str):
    stage, found = load_scene("grip"), find_subject(name)
    assert found.design.cell_mm == 0
    assert (found.rig, found.object, found.contact) == (stage.rig, stage.object, stage.contact)


def test_settings_and_another_object_reach_a_design():
    found = find_subject("mini-magictac", ["design.skin_mm=1.2", "seed=7"], object="box:size_mm=4x4x8")
    assert (found.design.skin_mm, found.seed) == (1.2, 7)
    assert found.object is not None
    assert found.object.kind == "box"


def test_unknown_names_are_answered_with_scenes_and_designs():
    with pytest.raises(PresetError, match=r"mini-magictac.*pressed"):
        find_subject("mini-magictoc")


def test_file_that_is_neither_is_refused(tmp_path: Path):
    file = tmp_path / "odd.toml"
    file.write_text("schema_version = 1\n", encoding="utf-8")
    with pytest.raises(ConfigError):
        find_subject(file)
