import pytest

from magicsim.deform.indentation.durometer import FRICTION
from magicsim.errors import ConfigError
from magicsim.geometry.design import Mounting

from .conftest import Shell

COARSE = ["uniform-block", "--set", "lattice.spacing_mm=2", "--set", "lattice.cells_across=0"]
BALL = ["--object", "sphere:radius_mm=4"]


def test_press_prints_the_contract_and_pushes_upwards(shell: Shell):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.5)
    assert set(found) == {
        "force_n", "torque_nmm", "contact_area_mm2", "max_penetration_mm", "min_jacobian", "force_balance",
        "iterations", "cutbacks", "restarts", "shifted", "rungs", "unknowns", "seconds", "converged", "history",
    }  # fmt: skip
    assert len(found["force_n"]) == len(found["torque_nmm"]) == 3
    assert found["force_n"][2] > 0.5
    assert found["converged"] is True
    assert 0 < found["unknowns"] < 3 * 13 * 17 * 3  # coarser away from the contact


def test_press_off_centre_with_shear_is_accepted(shell: Shell):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.3, "--shear-mm", "-0.5,0.5", "--twist-deg", -5)
    assert found["converged"] is True


def test_a_ball_that_the_points_miss_is_no_contact_of_force_zero(shell: Shell):
    missed = ["--object", "sphere:radius_mm=0.05", "--depth-mm", 0.2]
    assert "lies 0.2 mm inside the block" in shell.refusal("press", *COARSE, *missed)


def test_a_ball_pressed_by_several_diameters_is_refused_with_the_size_that_is_not(shell: Shell):
    deep = ["--object", "sphere:radius_mm=0.05", "--depth-mm", 0.5]
    assert "an object of at least 0.2 mm" in shell.refusal("press", "mini-magictac", *deep)


def test_press_writes_force_against_depth_and_still_prints_the_last_place(shell: Shell, tmp_path):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.4, "--curve", "ball.csv", "--points", 3)
    lines = (tmp_path / "ball.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in lines] == ["depth_mm", "0.0", "0.2", "0.4"]
    assert found["curve"] == "ball.csv"
    assert found["force_n"] == found["history"][-1]["force_n"]
    assert "must end in .csv or .png" in shell.refusal("press", *COARSE, *BALL, "--depth-mm", 0.4, "--curve", "ball")
    beside = ["--curve", "ball.png", "--twist-deg", 3]
    assert "twist_deg is not allowed with curve" in shell.refusal("press", *COARSE, *BALL, "--depth-mm", 0.4, *beside)


def test_press_says_what_the_print_bears(shell: Shell):
    weak = ["--set", "limits.elongation_at_break=[0.02,9]", "--set", "limits.tensile_strength_mpa=[8,9]"]
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.5, "--limits", *weak)
    assert list(found) == [
        "yield_depth_mm", "yield_force_n", "tear_depth_mm", "tear_force_n", "wall_tear_depth_mm", "wall_tear_force_n",
        "recommended_depth_mm", "recommended_force_n", "recommended_by", "onsets", "stopped", "spacing_mm",
        "skin_layers", "seconds", "history", "design_limits",
    ]  # fmt: skip
    assert 0 < found["tear_depth_mm"][0] < 0.5
    assert found["tear_depth_mm"][1] is None
    assert found["yield_depth_mm"] == [None, None]
    assert found["recommended_force_n"] == found["tear_force_n"][0] > 0


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ([], "--depth-mm is missing: only with --limits it may be left out"),
        (["--limits", "--twist-deg", 3], "twist_deg is not allowed with limits: they are of a straight press"),
        (["--limits", "--curve", "ball.csv"], "curve is not allowed with limits"),
        (["--limits"], "the design says no strength"),
    ],
)
def test_press_without_what_its_limits_need_is_one_line(shell: Shell, options: list[object], named: str):
    assert named in shell.refusal("press", *COARSE, *BALL, *options)


@pytest.mark.parametrize(
    ("depth", "named"),
    [
        ("inf", "depth_mm = inf is not allowed"),
        ("-1", "depth_mm = -1 is not allowed"),
        ("50", "depth_mm = 50 is not allowed"),
        ("0", "depth_mm = 0 is not allowed with curve: must be above 0"),
    ],
)
def test_depth_of_a_curve_is_refused_as_it_was_given(shell: Shell, depth: str, named: str):
    curve = ["--curve", "ball.csv", "--points", 3]
    assert named in shell.refusal("press", *COARSE, *BALL, "--depth-mm", depth, *curve)


def test_file_of_a_curve_that_cannot_be_written_is_refused_before_it_is_solved(
    shell: Shell, tmp_path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("magicsim.deform.indentation.press.press_curve", lambda *_, **__: pytest.fail("solved"))
    (tmp_path / "file").write_text("mine")
    refused = shell.refusal("press", *COARSE, *BALL, "--depth-mm", 0.2, "--curve", "file/ball.csv")
    assert "cannot write file/ball.csv: 'file' is not a folder" in refused


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--friction", "-0.1"], "friction = -0.1 is not allowed: must be 0 to 5 (rubber on most solids is below 2)"),
        (["--friction", "nan"], "friction = nan is not allowed"),
        (["--set", "mounting.friction=0.01"], "mounting.friction = 0.01 is not allowed"),
    ],
)
def test_friction_of_a_durometer_is_refused_in_one_line(shell: Shell, options: list[str], named: str):
    assert named in shell.refusal("durometer", *COARSE, *options)


def test_durometer_presses_with_the_friction_that_it_is_given(shell: Shell, monkeypatch: pytest.MonkeyPatch):
    asked = []

    def refuse(_: object, *, friction: float, mounting: Mounting, **__: object) -> None:
        asked.append((friction, mounting.friction))
        msg = "friction was heard"
        raise ConfigError(msg)

    monkeypatch.setattr("magicsim.deform.indentation.durometer.durometer", refuse)
    shell.refusal("durometer", *COARSE)
    shell.refusal("durometer", *COARSE, "--friction", 0.15, "--set", "mounting.friction=0.1")
    assert asked == [(FRICTION, 0.7), (0.15, 0.1)]
