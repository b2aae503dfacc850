"""Rooms, cameras and prints that the renderings of a sweep's designs have of their own."""

import pytest

from magicsim.errors import ConfigError
from magicsim.sweep.designs import list_designs, renderings_of, rows_of_renderings
from magicsim.sweep.explorer import rows_of
from magicsim.sweep.sweep_file import load_sweep
from sweep.fakes import small_sweep

DRAWS = (
    "tolerances.skin_roughness={low=0.05,high=0.2}", "tolerances.led_strength={mean=1.0,sd=0.05}",
    "tolerances.body_ior={mean=0.0,sd=0.003}", "camera.full_well_e={low=3e4,high=9e4}",
    "design.unevenness.wall_sd_mm=0.01",
)  # fmt: skip


def test_sweep_that_draws_nothing_sees_every_design_alike():
    sweep = small_sweep()
    design = list_designs(sweep)[0]
    found = renderings_of(design.sensor, sweep)
    assert [each.sensor for each in found] == [design.sensor] * sweep.quality.renderings
    assert rows_of_renderings(found) == {}


def test_draws_are_those_of_the_rendering_and_the_same_for_all_designs_wherever_they_stand():
    sweep = small_sweep(*DRAWS)
    first, *others = (renderings_of(each.sensor, sweep) for each in list_designs(sweep))
    for found in others:
        assert [each.drawn for each in found] == [each.drawn for each in first]
    one, other = first
    assert one.drawn.keys() == other.drawn.keys()
    assert all(one.drawn[name] != other.drawn[name] for name in one.drawn)
    assert {"sensor.skin_roughness", "sensor.led_strength.3", "camera.full_well_e", "camera.pattern_seed"} < set(
        one.drawn
    )
    assert [each.sensor.rig.camera.full_well_e for each in first] == [
        each.drawn["camera.full_well_e"] for each in first
    ]
    assert [each.sensor.design.roughness.skin for each in first] == [
        each.drawn["sensor.skin_roughness"] for each in first
    ]
    assert one.sensor.design.unevenness == other.sensor.design.unevenness  # shape is what renderings share
    assert renderings_of(list_designs(small_sweep(*DRAWS, "seed=2"))[0].sensor, small_sweep(*DRAWS, "seed=2")) != first


def test_rooms_come_by_turns_beside_the_draws():
    sweep = small_sweep(*DRAWS, "rooms=['office','dark']")
    found = renderings_of(list_designs(sweep)[0].sensor, sweep)
    assert [each.sensor.rig.room for each in found] == ["office", "dark"]
    assert len({each.sensor.rig.camera.pattern_seed for each in found}) == 2


def test_rows_name_camera_and_print_of_every_rendering():
    from magicsim.sweep.comparison import DesignTask, judge_design
    from magicsim.sweep.result import DesignResult

    sweep = small_sweep(*DRAWS, "measures=['printability']", "objectives=[{measure='printability'}]")
    design = list_designs(sweep)[0]
    result = DesignResult.from_json(judge_design(DesignTask(design=design, sweep=sweep)))
    (row,) = rows_of([result], [True])
    for turn, each in enumerate(renderings_of(design.sensor, sweep)):
        for name, value in each.drawn.items():
            assert row[f"renderings.{turn}.{name}"] == pytest.approx(value, rel=1e-7)


@pytest.mark.parametrize(
    ("setting", "complaint"),
    [
        ("tolerances.skin_mm={mean=0.0,sd=0.02}", r"tolerances\.skin_mm is not allowed in a sweep"),
        ("tolerances.stiffness=1.1", r"tolerances\.stiffness is not allowed in a sweep"),
        (
            "camera.flicker_depth=0.1",
            r"camera\.flicker_depth is not allowed in a sweep, as frames of a film have no times",
        ),
        ("camera.full_well={low=1,high=2}", "did you mean 'full_well_e'"),
    ],
)
def test_what_renderings_cannot_differ_by_is_one_line(setting: str, complaint: str):
    with pytest.raises(ConfigError, match=complaint) as error:
        small_sweep(setting)
    assert "\n" not in str(error.value)


def test_a_number_is_either_swept_or_drawn():
    swept = "swept=[{field='rig.camera.exposure_grey',values=[60.0]}]"
    with pytest.raises(ConfigError, match=r"camera\.exposure_grey is not allowed where that of the rig is swept"):
        small_sweep(swept, "camera.exposure_grey={low=50,high=70}")


def test_shipped_sweeps_draw_prints_and_cameras():
    for name in ("cell-skin", "print-sobol", "print-search"):
        assert load_sweep(name).draws


def test_hash_knows_the_draws():
    assert len({small_sweep(*more).config_hash() for more in ([], DRAWS[:1], DRAWS[3:4])}) == 3
