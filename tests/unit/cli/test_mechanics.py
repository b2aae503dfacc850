from .conftest import Shell

COARSE = ["uniform-block", "--set", "lattice.spacing_mm=2", "--set", "lattice.cells_across=0"]
BALL = ["--object", "sphere:radius_mm=4"]


def test_press_prints_the_contract_and_pushes_upwards(shell: Shell):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.5)
    assert set(found) == {
        "force_n", "torque_nmm", "contact_area_mm2", "max_penetration_mm", "min_jacobian", "force_balance",
        "iterations", "cutbacks", "restarts", "shifted", "unknowns", "seconds", "converged",
    }  # fmt: skip
    assert len(found["force_n"]) == len(found["torque_nmm"]) == 3
    assert found["force_n"][2] > 0.5
    assert found["converged"] is True
    assert 0 < found["unknowns"] < 3 * 13 * 17 * 3  # coarser away from the contact


def test_press_off_centre_with_shear_is_accepted(shell: Shell):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.3, "--shear-mm", "-0.5,0.5", "--twist-deg", -5)
    assert found["converged"] is True
