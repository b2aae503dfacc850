import pytest

from magicsim.errors import ConfigError
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import load_scene


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("rig.camera.principal_offset_px=[1e9,0]", "principal_offset_px.0 = 1000000000.0 is not allowed"),
        ("rig.camera.principal_offset_px=[121,0]", "must lie in the image of 240 x 320 pixels"),
        ("rig.camera.principal_offset_px=[0,-161]", "must lie in the image of 240 x 320 pixels"),
        ("rig.camera.read_noise_e=1e300", "read_noise_e = 1e+300 is not allowed"),
        ("rig.camera.read_noise_e=250001", "must be at most full_well_e = 250000"),
        ("rig.camera.exposure_grey=1e-300", "of at least 1 and at most 254"),
        ("rig.camera.distance_mm=1e-9", "of at least 1 and at most 2000"),
        ("rig.camera={distance_mm=1, field_mm=1000}", "field of view of 179 degrees must be at most 170"),
        ("rig.strips=[{side='-x', radiance=[1e30,0,0]}]", "must be less than or equal to 1000"),
        ("rig.strips=[{side='-x', radiance=[1e-9,0,0]}]", "must be 0 (off) or a number of at least 1e-06"),
        ("keyframes=[{frame=0, gap_mm=-6}]", "keyframes.0.gap_mm = -6 is not allowed: must be at least -5.94"),
        ("keyframes=[{frame=0, x_mm=1e6}]", "x_mm = 1000000.0 is not allowed: must be a number of at least -2000"),
    ],
)
def test_what_no_image_can_come_of_is_refused(setting: str, message: str):
    with pytest.raises(ConfigError) as error:
        load_scene("near", [setting])
    assert message in str(error.value)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("radiances", "ambient", "lit"),
    [
        ([], (0.0, 0.0, 0.0), (False, False, False)),
        ([(5.0, 0.0, 0.0), (0.0, 0.0, 0.0)], (0.0, 0.0, 0.0), (True, False, False)),
        ([(5.0, 0.0, 0.0)], (0.0, 0.0, 1.0), (True, False, True)),
    ],
)
def test_channels_are_lit_by_any_light_of_the_untouched_sensor(radiances: list, ambient: tuple, lit: tuple):
    strips = [{"side": "-x", "radiance": each} for each in radiances]
    assert Rig.model_validate({"schema_version": 1, "strips": strips, "ambient": ambient}).lit == lit
