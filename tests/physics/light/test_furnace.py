"""White furnace and energy balance: in a world of equal radiance nothing loses or gains light, at rest and deformed."""

import pytest
from laboratory.light.optics import CASES, check_optics

from magicsim.light.variant import SCALAR_VARIANT, activate_variant

pytestmark = pytest.mark.skipif(activate_variant() == SCALAR_VARIANT, reason="needs LLVM or CUDA")
SMALL = ("design.footprint_mm=[8, 9]", "rig.camera.field_mm=7.5")
QUICK = ("default, rest", "default, 1 mm press")


def check(case, *overrides):
    row = check_optics(case, *overrides)
    assert row.is_finite
    assert abs(row.camera_error) < 0.005
    assert abs(row.balance_error) < 0.005
    if case != "no scattering":
        assert abs(row.fluence_error) < 0.005
        assert row.most_cell < 0.25
        assert row.least_cell > -0.25


@pytest.mark.parametrize("case", QUICK)
def test_small_sensor_keeps_its_light(case):
    check(case, *SMALL)


@pytest.mark.slow
def test_an_uneven_print_keeps_its_light():
    check("default, rest", *SMALL, "design.unevenness.wall_sd_mm=0.015", "design.unevenness.wave_sd_mm=0.05")


SHIFTED = (
    "design.unevenness.pitch_scale=[1.02,0.98,1.02]", "design.unevenness.pitch_drift=[0.04,-0.04,0.0]",
    "design.unevenness.skin_sd_mm=0.05",
)  # fmt: skip


def test_a_print_of_another_pitch_and_an_uneven_skin_keeps_its_light_under_a_press():
    check("default, 1 mm press", *SMALL, *SHIFTED)


TORN = ("design.unevenness.torn_share=0.1", "design.materials.infill.ior=1.42")


def test_a_print_that_lacks_walls_keeps_its_light_under_a_press():
    check("default, 1 mm press", *SMALL, *TORN)


ROUGH = ("design.roughness.skin=0.2", "design.roughness.walls=0.2")
INCLUSIONS = (
    "design.inclusions.bubbles_per_mm3=2", "design.inclusions.bubble_radius_mm=[0.05,0.2]",
    "design.inclusions.flakes_per_mm3=2", "design.inclusions.flake_radius_mm=[0.05,0.2]",
    "design.inclusions.flake_reflectance=1",
)  # fmt: skip

FILLETS = ("design.unevenness.crossing_radius_mm=0.15",)


@pytest.mark.parametrize(
    ("case", "flaws"),
    [
        pytest.param("default, rest", ROUGH, marks=pytest.mark.slow),
        pytest.param("default, rest", INCLUSIONS, marks=pytest.mark.slow),
        pytest.param("default, rest", FILLETS, marks=pytest.mark.slow),
        ("default, 1 mm press", (*ROUGH, *INCLUSIONS, *FILLETS)),
    ],
)
def test_a_print_with_flaws_keeps_its_light(case, flaws):
    check(case, *SMALL, *flaws)


@pytest.mark.parametrize(
    "coat",
    [
        'design.coat={kind="opaque",color=[1.0,1.0,1.0]}',
        'design.coat={kind="half_mirror",reflectance=0.5,transmittance=0.5}',
    ],
)
def test_a_face_without_losses_keeps_its_light(coat):
    check("default, rest", *SMALL, coat)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_extreme_sensor_keeps_its_light(case):
    check(case)
