from pathlib import Path

import pytest

from magicsim.errors import ConfigError, PresetError
from magicsim_experiments.study.study_file import load_study, merged, usual_rig

from .fakes import KINDS

BEAM = Path(__file__).with_name("beam.toml")


def beam(*overrides: str, **options):
    return load_study(BEAM, overrides, kinds=KINDS, **options)


def test_quick_puts_its_table_over_the_rest():
    assert beam().config.forces_n == (1.0, 2.0, 3.0, 4.0)
    assert beam(quick=True).config.forces_n == (1.0, 2.0)
    assert merged({"a": {"b": 1, "c": 2}, "d": [1]}, {"a": {"b": 3}, "d": [2]}) == {"a": {"b": 3, "c": 2}, "d": [2]}


def test_design_comes_with_the_rig_of_its_scene():
    assert usual_rig("gelsight-type-markers") == "three-sides-rgb"
    assert usual_rig("uniform-block") == "digit-office"
    assert beam(design="mini-magictac").config.rig.room is not None
    assert beam("rig=digit-rgb").config.rig.room is None


def test_overrides_reach_study_design_and_rig():
    found = beam("design.skin_mm=1.2", "rig.camera.exposure_grey=70", "forces_n=[5.0]", seed=4).config
    assert (found.design.skin_mm, found.rig.camera.exposure_grey) == (1.2, 70.0)
    assert (found.forces_n, found.seed) == ((5.0,), 4)


@pytest.mark.parametrize(
    ("overrides", "options", "told"),
    [
        ([], {"design": "marker-type"}, "needs a design with a grid"),
        (["forces=1"], {}, "unknown key 'forces'"),
        (["forces_n=[-1.0]"], {}, "forces_n"),
    ],
)
def test_bad_input_is_one_line(overrides, options, told):
    with pytest.raises(ConfigError, match=told) as refused:
        beam(*overrides, **options)
    assert "\n" not in str(refused.value)


def test_unknown_study_design_or_kind_is_named():
    with pytest.raises(PresetError, match="unknown study 'tasting'"):
        load_study("tasting")
    with pytest.raises(PresetError, match="unknown design 'mini'"):
        beam(design="mini")
    with pytest.raises(ConfigError, match="unknown kind of study 'beam'"):
        load_study(BEAM)
