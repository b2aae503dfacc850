import dataclasses

import pytest

from magicsim.detectors import DetectorProfile, load_profile, save_profile
from magicsim.errors import ConfigError, OutputError, PresetError


def test_published_preset_is_the_default_profile():
    assert load_profile("published") == DetectorProfile()


def test_saved_profile_reads_back_unchanged(tmp_path):
    profile = DetectorProfile(tau_e=0.1 + 0.2, tau_c=-0.25, polarity="bright", similarity="dice", tau_b=50)
    path = tmp_path / "mine.toml"
    save_profile(profile, path, comment="Fitted to two episodes.\nNothing assumed.")
    assert load_profile(path) == profile
    assert path.read_text().startswith("# Fitted to two episodes.\n# Nothing assumed.\n")
    assert [each.name for each in tmp_path.iterdir()] == ["mine.toml"]


def test_saving_without_a_comment_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="comment"):
        save_profile(DetectorProfile(), tmp_path / "mine.toml", comment=" \n")


def test_saving_to_a_missing_folder_is_one_line(tmp_path):
    with pytest.raises(OutputError, match="cannot be written"):
        save_profile(DetectorProfile(), tmp_path / "none" / "mine.toml", comment="x")


def test_left_out_keys_keep_their_defaults(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("tau_g = 0.8\n")
    assert load_profile(path) == DetectorProfile(tau_g=0.8)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("tau_ee = 1.0", ["'tau_ee'", "did you mean 'tau_e'", "transport_frames"]),
        ("tau_g = nan", ["tau_g = nan", "0..1"]),
        ("tau_g = '0.5'", ["tau_g = '0.5'", "0..1"]),
        ("tau_b = 300", ["tau_b = 300", "0..254"]),
        ("[tau_b]\nvalue = 3", ["tau_b", "0..254"]),
        ("tau_b = ", ["not valid TOML"]),
    ],
)
def test_bad_file_is_one_line_with_file_field_and_choices(tmp_path, text, named):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_profile(path)
    assert "\n" not in str(caught.value)
    for part in [str(path), *named]:
        assert part in str(caught.value)


def test_file_that_is_not_text_is_one_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="not valid TOML"):
        load_profile(path)


def test_unknown_name_lists_the_profiles():
    with pytest.raises(PresetError, match=r"did you mean 'published'"):
        load_profile("publisched")


def test_facing_is_calibrated_with_the_threshold_of_the_published_grasping_run():
    assert load_profile("facing") == dataclasses.replace(load_profile("calibrated"), tau_g=0.7)
