"""White furnace and energy balance: in a world of equal radiance nothing loses or gains light, at rest and deformed."""

import pytest
from laboratory.light.optics import CASES, check_optics

from magicsim.light.variant import SCALAR_VARIANT, activate_variant

pytestmark = pytest.mark.skipif(activate_variant() == SCALAR_VARIANT, reason="needs LLVM or CUDA")
SMALL = ("design.footprint_mm=[8, 9]", "rig.camera.field_mm=7.5", "render.samples=4", "render.particles=6000")
SHARE = 0.4
"""Of the particles: 600 a cell of the small block, whose mean then wanders by 0.1 %, the balance by up to 0.2 %."""


def check(case, *overrides, share=1.0):
    row = check_optics(case, *overrides, share=share)
    assert row.is_finite
    assert abs(row.camera_error) < 0.005
    assert abs(row.balance_error) < 0.005
    if case != "no scattering":
        assert abs(row.fluence_error) < 0.005
        assert row.most_cell < 0.25
        assert row.least_cell > -0.25


UNEVEN = ("design.unevenness.wall_sd_mm=0.015", "design.unevenness.wave_sd_mm=0.05")
SHIFTED = (
    "design.unevenness.pitch_scale=[1.02,0.98,1.02]", "design.unevenness.pitch_drift=[0.04,-0.04,0.0]",
    "design.unevenness.skin_sd_mm=0.05",
)  # fmt: skip
TORN = ("design.unevenness.torn_share=0.1", "design.materials.infill.ior=1.42")
ROUGH = ("design.roughness.skin=0.2", "design.roughness.walls=0.2")
INCLUSIONS = (
    "design.inclusions.bubbles_per_mm3=2", "design.inclusions.bubble_radius_mm=[0.05,0.2]",
    "design.inclusions.flakes_per_mm3=2", "design.inclusions.flake_radius_mm=[0.05,0.2]",
    "design.inclusions.flake_reflectance=1",
)  # fmt: skip
FILLETS = ("design.unevenness.crossing_radius_mm=0.15",)
OPAQUE = ('design.coat={kind="opaque",color=[1.0,1.0,1.0]}',)
HALF_MIRROR = ('design.coat={kind="half_mirror",reflectance=0.5,transmittance=0.5}',)


@pytest.mark.parametrize(
    ("case", "flaws"),
    [
        ("default, rest", OPAQUE),
        ("default, rest", (*HALF_MIRROR, *FILLETS)),
        ("default, 1 mm press", (*SHIFTED, *TORN, *ROUGH, *INCLUSIONS)),
        pytest.param("default, rest", (), marks=pytest.mark.slow),
        pytest.param("default, 1 mm press", (), marks=pytest.mark.slow),
        pytest.param("default, 1 mm press", SHIFTED, marks=pytest.mark.slow),
        pytest.param("default, 1 mm press", TORN, marks=pytest.mark.slow),
        *(pytest.param("default, rest", each, marks=pytest.mark.slow) for each in (UNEVEN, ROUGH, INCLUSIONS, FILLETS)),
    ],
)
def test_small_sensor_keeps_its_light_whatever_its_print_and_coat(case, flaws):
    check(case, *SMALL, *flaws, share=SHARE)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_extreme_sensor_keeps_its_light(case):
    check(case)
