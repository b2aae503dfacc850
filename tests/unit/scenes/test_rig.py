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
        ("rig.camera.faults.dark_e=250001", "faults.dark_e = 250001 is not allowed: must be at most full_well_e"),
        ("rig.camera.faults.hot_share=0.2", "faults.hot_share = 0.2 is not allowed: must be a number of at least 0"),
        ("rig.camera.faults.warm=1", "unknown key in [rig.camera.faults] 'warm'"),
        (
            "rig.camera.live={time_constant_frames=0.5,delay_frames=2}",
            "would swing and never settle; must be above 1.04",
        ),
        ("rig.camera.live={white_balance_frames=1,delay_frames=4}", "white_balance_frames = 1 is not allowed with"),
        ("rig.camera.live={gain_limits=[2,8]}", "live.gain_limits.0 = 2 is not allowed"),
        ("rig.camera.live={metering='spot'}", "live.metering = 'spot' is not allowed: must be 'mean' or 'centre'"),
        (
            "rig.camera.shutter.row_us=250",
            "320 rows are read in 80 ms, which must be at most the 66.7 ms between frames",
        ),
        ("rig.camera.shutter.exposure_ms=0", "shutter.exposure_ms = 0 is not allowed"),
        ("rig.camera.flicker={depth=1.5}", "flicker.depth = 1.5 is not allowed: must be a number of at least 0"),
        ("rig.camera.led_drift={share=0.5}", "led_drift.share = 0.5 is not allowed"),
        (
            "rig.camera.glare={share=1}",
            "glare.share = 1 is not allowed: must be a number of at least 0 and at most 0.9",
        ),
        ("rig.camera.diffraction={wavelengths_nm=[500,500]}", "diffraction.wavelengths_nm"),
        ("rig.camera.diffraction={f_number=0}", "diffraction.f_number = 0 is not allowed"),
        ("rig.camera.dust={specks=-1}", "dust.specks = -1 is not allowed"),
        ("rig.camera.vibration_px=6", "vibration_px = 6 is not allowed: must be a number of at least 0 and at most 5"),
        ("rig.camera.compression={kind='mp4'}", "compression.kind 'mp4'"),
        ("rig.camera.compression={quality=80}", "compression.kind is missing"),
        ("rig.camera.compression={kind='mjpeg',quality=0}", "quality = 0 is not allowed"),
        (
            "rig.camera={compression={kind='h264'},rows=321}",
            "'h264' is not allowed with 240 x 321 pixels: must be even",
        ),
        ("rig.camera={region_px=[0,0,8,8],glare={}}", "region_px is not allowed with glare: it needs the whole image"),
        ("rig.camera={region_px=[0,0,8,8],shutter={moves=true}}", "region_px is not allowed with shutter.moves"),
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
    ("radiances", "ambient", "is_opaque", "lit"),
    [
        ([], (0.0, 0.0, 0.0), False, (False, False, False)),
        ([(5.0, 0.0, 0.0), (0.0, 0.0, 0.0)], (0.0, 0.0, 0.0), False, (True, False, False)),
        ([(5.0, 0.0, 0.0)], (0.0, 0.0, 1.0), False, (True, False, True)),
        ([(5.0, 0.0, 0.0)], (0.0, 0.0, 1.0), True, (True, False, False)),
    ],
)
def test_channels_are_lit_by_any_light_of_the_untouched_sensor(radiances, ambient, is_opaque, lit):
    strips = [{"side": "-x", "radiance": each} for each in radiances]
    rig = Rig.model_validate({"schema_version": 1, "strips": strips, "ambient": ambient})
    assert rig.lit(is_opaque=is_opaque) == lit
