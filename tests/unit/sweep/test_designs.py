from itertools import product

import numpy as np
import pytest

from magicsim.camera.projection import picture_mm
from magicsim.errors import ConfigError
from magicsim.geometry.design import LatticeOptions
from magicsim.sweep.designs import camera_of, list_designs
from magicsim.sweep.sweep_file import SweepConfig, load_sweep

from .fakes import small_sweep

Size = tuple[int, int]


def test_grid_holds_every_combination_the_last_field_fastest():
    designs = list_designs(small_sweep())
    values = [(each.values["design.cell_mm"], each.values["design.skin_mm"]) for each in designs]
    assert values == [(0.8, 0.5), (0.8, 1.0), (1.2, 0.5), (1.2, 1.0)]
    assert [each.index for each in designs] == [0, 1, 2, 3]
    assert [(each.sensor.design.cell_mm, each.sensor.design.skin_mm) for each in designs] == values


def test_interval_on_a_grid_has_its_count_of_values():
    swept = "swept=[{field='design.skin_mm',low=0.5,high=2.0,count=3,scale='log'}]"
    assert [each.values["design.skin_mm"] for each in list_designs(small_sweep(swept))] == [0.5, 1.0, 2.0]


def test_more_quasi_random_designs_leave_the_first_ones_as_they_are():
    swept = "swept=[{field='design.skin_mm',low=0.5,high=1.5},{field='rig.camera.gamma',values=[1.0,2.2]}]"
    few, many = (list_designs(small_sweep(swept, "sampling='sobol'", f"count={count}")) for count in (5, 9))
    assert [each.values for each in few] == [each.values for each in many[:5]]
    assert all(0.5 <= each.values["design.skin_mm"] <= 1.5 for each in many)
    assert {each.values["rig.camera.gamma"] for each in many} == {1.0, 2.2}


def test_other_seeds_give_other_quasi_random_designs():
    swept = ("swept=[{field='design.skin_mm',low=0.5,high=1.5}]", "sampling='sobol'", "count=4")
    one, other = (list_designs(small_sweep(*swept, f"seed={seed}")) for seed in (1, 2))
    assert [each.values for each in one] != [each.values for each in other]


def test_further_designs_are_the_base_with_their_own_fields_changed():
    *grid, extra = list_designs(small_sweep("also=[{'design.core_mm'=3.0}]"))
    assert extra.is_extra
    assert extra.values == {"design.cell_mm": 0.8, "design.skin_mm": 0.8, "design.core_mm": 3.0}
    assert extra.sensor.design.core_mm == 3.0
    assert {each.values["design.core_mm"] for each in grid} == {5.0}


def test_entries_of_a_list_are_counted():
    swept = "swept=[{field='rig.strips.1.margin_mm',values=[0.5,2.0]}]"
    designs = list_designs(small_sweep(swept))
    assert [each.sensor.rig.strips[1].margin_mm for each in designs] == [0.5, 2.0]
    assert {each.sensor.rig.strips[0].margin_mm for each in designs} == {0.4}


def test_rooms_are_swept_by_their_names():
    swept = "swept=[{field='rig.room',values=['office','corridor']},{field='design.skin_mm',values=[0.5,1.0]}]"
    designs = list_designs(small_sweep("rig=digit-office", swept, "also=[{'rig.room'='dark'}]"))
    rooms = [each.values["rig.room"] for each in designs]
    assert rooms == ["office", "office", "corridor", "corridor", "dark"]
    assert [each.sensor.rig.room for each in designs] == rooms
    assert [each.sensor.rig.moving is not None for each in designs] == [False, False, True, True, False]
    drawn = list_designs(small_sweep("rig=digit-office", swept, "sampling='sobol'", "count=8"))
    assert [each.values["rig.room"] for each in drawn].count("office") == 4


@pytest.mark.parametrize(
    ("swept", "named"),
    [
        ("{field='design.skin_mm',values=['office']}", "'design.skin_mm' is not allowed: must be a name, not 0.8"),
        ("{field='rig.room',values=[1.0,'office']}", "field 'rig.room' is not allowed: must be a number, not 'office'"),
        (
            "{field='rig.room',values=['offise']}",
            "unknown room (or a PNG or JPEG file) 'offise' (did you mean 'office'?)",
        ),
        ("{field='design.skn_mm',values=[1.0]}", "field 'design.skn_mm' 'skn_mm' (did you mean 'skin_mm'?)"),
        ("{field='design.skin_mm',values=[-1.0]}", "design.skin_mm = -1.0 is not allowed"),
        ("{field='design.materials',values=[1.0]}", "field 'design.materials' is not allowed: must be a number"),
        ("{field='rig.camera.white_balance',values=[1.0]}", "must be a number"),
        ("{field='rig.strips.7.margin_mm',values=[1.0]}", "'7'; available: 0, 1, 2, 3"),
        ("{field='rig.camera.pattern_seed',values=[100.5]}", "rig.camera.pattern_seed = 100.5 is not allowed"),
    ],
)
def test_field_that_does_not_exist_or_a_value_out_of_range_is_named(swept: str, named: str):
    with pytest.raises(ConfigError) as error:
        list_designs(small_sweep("rig=digit-office", f"swept=[{swept}]"))
    assert named in str(error.value)
    assert "\n" not in str(error.value)


def test_field_without_a_value_of_its_own_may_be_swept_but_needs_one_in_every_design():
    def bare(*more: str) -> SweepConfig:
        sweep = small_sweep("swept=[{field='design.lattice.spacing_mm',values=[0.5,1.0]}]", *more)
        return sweep.model_copy(update={"design": sweep.design.model_copy(update={"lattice": LatticeOptions()})})

    assert [each.values["design.lattice.spacing_mm"] for each in list_designs(bare())] == [0.5, 1.0]
    with pytest.raises(ConfigError, match="spacing_mm' has no value in the base sensor"):
        list_designs(bare("also=[{'design.core_mm'=3.0}]"))


@pytest.mark.parametrize(
    ("own", "asked", "seen"),
    [
        ((240, 320), (48, 64), (48, 64)),
        ((320, 240), (48, 64), (64, 48)),
        ((320, 240), (64, 48), (64, 48)),
        ((320, 320), (48, 75), (60, 60)),
    ],
)
def test_images_keep_the_shape_of_the_rigs_and_show_as_much(own: Size, asked: Size, seen: Size):
    sweep = small_sweep(
        f"rig.camera.columns={own[0]}", f"rig.camera.rows={own[1]}", "rig.camera.principal_offset_px=[8,-4]",
        f"quality.columns={asked[0]}", f"quality.rows={asked[1]}",
    )  # fmt: skip
    sensor = list_designs(sweep)[0].sensor
    whole, small = sensor.rig.camera, camera_of(sensor, sweep.quality)
    assert (small.columns, small.rows) == seen
    covered = [picture_mm(sensor.design, sensor.rig.lens, camera) for camera in (whole, small)]
    assert covered[1] == pytest.approx(covered[0], abs=0.5)  # outermost pixels are half a pixel from the edge


def test_shipped_sweep_is_six_by_six_and_two_other_cores():
    designs = list_designs(load_sweep("cell-skin"))
    assert len(designs) == 38
    assert [each.values["design.core_mm"] for each in designs if each.is_extra] == [3.0, 8.0]


def test_shipped_sweep_of_curvatures_is_nine_domes_and_an_all_but_flat_one():
    *domes, flat = list_designs(load_sweep("dome-curvature"))
    faces = [each.sensor.design.face for each in domes]
    assert [(face.radius_x_mm, face.radius_y_mm) for face in faces] == list(product((20, 40, 80), (30, 60, 120)))
    assert {face.crown_mm for face in faces} == {1.6}
    assert flat.sensor.design.rise_mm(np.array([[12.0, 16.0]])).max() < 0.03
