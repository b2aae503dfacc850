import re
from pathlib import Path

import pytest
from PIL import Image

from magicsim.errors import ConfigError, PresetError
from magicsim.sweep.sweep_file import load_sweep

from .fakes import small_sweep


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        (
            "swept=[{field='desing.skin_mm',values=[1.0]}]",
            "unknown field 'desing.skin_mm'; available: design.*, render.*, rig.*",
        ),
        ("swept=[{field='design.skin_mm'}]", "needs either values, or low and high"),
        ("swept=[{field='design.skin_mm',values=[1.0,1.0]}]", "holds a value twice"),
        ("swept=[{field='design.skin_mm',values=[1.0,2.0],count=3}]", "count and scale of 'design.skin_mm'"),
        ("swept=[{field='design.skin_mm',low=2.0,high=1.0,count=3}]", "must be at most high = 1"),
        ("swept=[{field='design.skin_mm',low=0.5,high=1.0}]", "count is missing"),
        ("swept=[{field='design.skin_mm',values=[1.0],step=2}]", "unknown key in [swept.0] 'step'"),
        ("count=8", "not allowed with sampling = 'grid'"),
        ("sampling='sobol'", "count is missing"),
        ("sampling='latin'", "sampling = 'latin' is not allowed"),
        ("measures=['shore_b']", "unknown measure 'shore_b' (did you mean 'shore_a'?)"),
        ("objectives=[{measure='shore_a'}]", "better is missing"),
        ("objectives=[{measure='unknowms'}]", "unknown measure 'unknowms' (did you mean 'unknowns'?)"),
        ("measures=['shore_a']", "unknown objective 'sensitivity_per_n'"),
        ("quality.gaps_mm=[1.0,2.0,3.0]", "must fall"),
        ("quality.depths_mm=[0.1,0.2,0.3,0.9]", "must hold 1.0"),
        ("quality.depths_mm=[1.0,2.0]", "must hold 1.0 and a smaller value"),
        ("quality.light_depth_mm=0.3", "light_depth_mm = 0.3 is not allowed: must be below 0.3"),
        ("quality.line_spacings_mm=[0.2]", "must be greater than or equal to 0.3"),
        ("quality.columms=10", "did you mean 'columns'"),
        ("rooms=['offise']", "unknown room (or a PNG or JPEG file) 'offise' (did you mean 'office'?)"),
        ("rooms=['office','corridor']", "rooms = 'corridor' is not allowed: something passes there"),
        ("rooms=['office','window','bench']", "must be at most quality.renderings = 2"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(setting: str, named: str):
    with pytest.raises(ConfigError) as error:
        small_sweep(setting)
    assert named in str(error.value)
    assert "\n" not in str(error.value)


def test_unknown_sweep_is_named_with_the_nearest_one():
    with pytest.raises(PresetError, match="did you mean 'cell-skin'"):
        load_sweep("cell-skn")


def test_hash_knows_what_results_depend_on_and_nothing_else():
    base = small_sweep().config_hash()
    assert small_sweep("timeout_s=1").config_hash() == base
    assert small_sweep("objectives=[{measure='shore_a',better='lower'}]").config_hash() == base
    assert small_sweep("quality.touches=7").config_hash() != base
    assert small_sweep("design.core_mm=4").config_hash() != base


def test_hash_follows_the_pictures_of_swept_rooms(tmp_path: Path):
    picture = tmp_path / "room.png"
    swept = f"swept=[{{field='rig.room',values=['office','{picture}']}}]"
    hashes = []
    for grey in (50, 200):
        Image.new("RGB", (64, 32), (grey, 100, 100)).save(picture)
        hashes.append(small_sweep("rig=digit-office", swept).config_hash())
    assert hashes[0] != hashes[1]


def test_rooms_are_either_swept_or_drawn_on_in_every_design():
    with pytest.raises(ConfigError, match=r"rooms is not allowed where 'rig\.room' is swept"):
        small_sweep("rig=digit-office", "rooms=['office']", "also=[{'rig.room'='window'}]")


def test_shipped_sweeps_see_every_design_in_several_rooms():
    for name in ("cell-skin", "dome-curvature", "print-sobol", "print-search"):
        sweep = load_sweep(name)
        assert len(set(sweep.rooms)) == sweep.quality.renderings > 1


def test_hash_follows_the_pictures_of_rooms_beside_the_file(tmp_path: Path):
    (tmp_path / "mine.toml").write_text(Path(__file__).with_name("small.toml").read_text().replace(
        "seed = 1\n", "seed = 1\nrooms = ['room.png']\n"
    ).replace("digit-rgb", "digit-office"))  # fmt: skip
    hashes = []
    for grey in (50, 200):
        Image.new("RGB", (64, 32), (grey, 100, 100)).save(tmp_path / "room.png")
        hashes.append(load_sweep(tmp_path / "mine.toml").config_hash())
    assert hashes[0] != hashes[1]


def test_hash_knows_the_rooms():
    office, window = (small_sweep(f"rooms=['{room}']").config_hash() for room in ("office", "window"))
    assert len({office, window, small_sweep().config_hash()}) == 3


def test_a_seed_of_the_command_line_takes_the_place_of_the_files():
    assert load_sweep("cell-skin", seed=5).seed == 5


def test_durability_is_measured_only_where_it_is_named():
    usual = small_sweep().measures
    assert "force_1mm_n" in usual
    assert not set(usual) & {"force_at_yield_n", "force_at_tear_n", "safe_depth_mm"}
    assert (
        "safe_depth_mm" in small_sweep("measures=['safe_depth_mm']", "objectives=[{measure='safe_depth_mm'}]").measures
    )


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (
            ["swept=[{field='render.samples',values=[2,8]}]"],
            "render.samples is not allowed to be swept: quality",
        ),
        (["also=[{'render.anchor_particles'=50000}]"], "quality.anchor_particles has it for all designs"),
        (["swept=[{field='rig.camera.shutter.exposure_ms',values=[5.0,10.0]}]"], "frames of a film have no times"),
        (
            ["rig.camera.shutter.row_us=10", "also=[{'rig.camera.shutter.row_us'=50.0}]"],
            "frames of a film have no times",
        ),
        (["swept=[{field='rig.camera.columns',values=[120,240]}]"], "quality.columns has it for all designs"),
        (["rig.camera.region_px=[0,0,100,100]"], "rig.camera.region_px is not allowed in a sweep"),
        (["render.tier=fast"], "render.tier = 'fast' is not allowed: a sweep's frames are true ones"),
    ],
)
def test_what_would_change_no_frame_is_refused(settings: list[str], told: str):
    with pytest.raises(ConfigError, match=re.escape(told)):
        small_sweep(*settings)
