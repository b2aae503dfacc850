"""A description is checked as a whole, and every problem is one line."""

from pathlib import Path

import pytest

from magicsim.dataset.real.description import PUBLIC, load_real
from magicsim.errors import ConfigError, PresetError

from .drawn import describe


def test_columns_are_those_of_public_sets_by_default(tmp_path: Path):
    found = load_real(describe(tmp_path, 'frames = "images"')).description
    assert found.columns == PUBLIC
    assert (found.columns.image, found.columns.force_n) == ("image_name", ("fx", "fy", "fz"))


def test_paths_start_in_the_folder_of_the_file(tmp_path: Path):
    real = load_real(describe(tmp_path, 'frames = "images"'))
    assert real.path("images") == tmp_path / "images"


def test_settings_override_the_file(tmp_path: Path):
    found = load_real(describe(tmp_path, 'frames = "images"'), ["frames.rotate_deg=90", "columns.depth_mm=mm"])
    assert found.description.frames.rotate_deg == 90
    assert found.description.columns.depth_mm == "mm"


@pytest.mark.parametrize(
    ("lines", "top", "said"),
    [
        (
            ["frames = 'a'", "untouched = 'b'", "untouched_first = 3"],
            [],
            "untouched_first is not allowed with untouched",
        ),
        (["frames = 'a'", "gain = 0"], [], "recordings.0.gain = 0"),
        (["frames = 'a'"], ["frames.rotate_deg = 45"], "frames.rotate_deg = 45"),
        (["frames = 'a'"], ["frames.colour_order = 'bgr'"], "did you mean 'color_order'"),
        (["frames = 'a'"], ["columns.force_n = ['fx', 'fy']"], "columns.force_n"),
        (["frames = 'a'", "split = 'my set'"], [], "split"),
    ],
)
def test_what_is_not_allowed_is_named(tmp_path: Path, lines: list[str], top: list[str], said: str):
    with pytest.raises(ConfigError) as caught:
        load_real(describe(tmp_path, *lines, top=top))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_file_that_does_not_exist_is_told(tmp_path: Path):
    with pytest.raises(PresetError, match="does not exist; must be a TOML file"):
        load_real(tmp_path / "none.toml")
