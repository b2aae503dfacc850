from pathlib import Path

import pytest

from magicsim.config.presets import find_preset
from magicsim.errors import ConfigError, PresetError
from magicsim.scenes.scene import load_scene

SCENE = """
schema_version = 1
design = "{design}"
rig = "digit-rgb"
[[keyframes]]
frame = 0
"""


def write_scene(folder: Path, design: str = "uniform-block") -> Path:
    path = folder / "mine.toml"
    path.write_text(SCENE.format(design=design))
    return path


def test_named_design_and_rig_are_put_in_place():
    scene = load_scene("near")
    assert scene.design.cell_mm == 0.8
    assert {strip.side for strip in scene.rig.strips} == {"-x", "+x", "-y", "+y"}


def test_overrides_reach_into_the_design_and_the_rig():
    scene = load_scene("near", ["design.skin_mm=0.6", "rig.camera.columns=48", "object.radius_mm=4"])
    assert scene.design.skin_mm == 0.6
    assert scene.design.core_mm == 5.0
    assert scene.rig.camera.columns == 48
    assert scene.object is not None
    assert scene.object.kind == "sphere"
    assert scene.object.color == (0.85, 0.45, 0.15)


def test_design_can_be_exchanged_and_changed_in_any_order():
    for settings in (["design=uniform-block", "design.skin_mm=0.7"], ["design.skin_mm=0.7", "design=uniform-block"]):
        design = load_scene("near", settings).design
        assert not design.has_grid
        assert design.skin_mm == 0.7


def test_file_beside_the_scene_is_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "there").mkdir()
    text = find_preset("design", "uniform-block").read_text().replace("core_mm = 5.0", "core_mm = 7.0")
    (tmp_path / "there" / "block.toml").write_text(text)
    path = write_scene(tmp_path / "there", design="block.toml")
    monkeypatch.chdir(tmp_path)
    assert load_scene(path).design.core_mm == 7.0
    assert load_scene(path, ["design=block.toml"]).design.core_mm == 7.0


def test_design_may_stand_in_the_scene_itself(tmp_path: Path):
    block = find_preset("design", "uniform-block").read_text()
    table = block.replace("[materials", "[design.materials").replace("[lattice]", "[design.lattice]")
    path = tmp_path / "whole.toml"
    path.write_text(f'schema_version = 1\nrig = "digit-rgb"\nkeyframes = [{{frame = 0}}]\n[design]\n{table}')
    assert load_scene(path).design == load_scene("rest", ["design=uniform-block"]).design


def test_seed_replaces_that_of_the_file():
    assert load_scene("near").seed == 1
    assert load_scene("near", seed=7).seed == 7
    assert load_scene("near", ["seed=5"], seed=7).seed == 7
    with pytest.raises(ConfigError, match="seed = -7"):
        load_scene("near", seed=-7)


@pytest.mark.parametrize(("kind", "key"), [("design", "design"), ("rig", "rig")])
def test_unknown_design_or_rig_lists_the_choices(kind: str, key: str):
    with pytest.raises(PresetError, match=f"unknown {kind} 'none'; available: "):
        load_scene("near", [f"{key}=none"])


def test_a_loose_block_is_refused_since_its_image_needs_the_lens():
    with pytest.raises(ConfigError, match=r"design\.mounting\.base = 'table' is not allowed in a scene"):
        load_scene("rest", ["design.mounting.base=table"])


def test_missing_design_file_is_named(tmp_path: Path):
    with pytest.raises(PresetError, match=r"design file 'gone\.toml' does not exist"):
        load_scene(write_scene(tmp_path, design="gone.toml"))


@pytest.mark.parametrize(
    "frames", [[1], [0, 0], [0, 5, 3], [3, 0]], ids=["not from 0", "twice", "backwards", "from the middle"]
)
def test_keyframes_must_start_at_zero_and_increase(frames: list[int]):
    keyframes = ", ".join(f"{{frame={frame}}}" for frame in frames)
    with pytest.raises(ConfigError, match="must start at 0 and increase"):
        load_scene("rest", [f"keyframes=[{keyframes}]"])


def test_gap_without_an_object_is_refused():
    with pytest.raises(ConfigError, match="object is missing"):
        load_scene("rest", ["keyframes=[{frame=0, gap_mm=1.0}]"])


def test_last_keyframe_is_the_last_frame():
    assert load_scene("rest", ["keyframes=[{frame=0}, {frame=9}]"]).frame_count == 10
    assert load_scene("rest").frame_count == 1


def test_defaults_follow_the_published_reference_count():
    scene = load_scene("rest")
    assert scene.references == 30
    assert scene.render.estimator == "fluence"
