"""CSV files with other names, units and signs become labels in ours."""

import math
from pathlib import Path

import pytest

from magicsim.dataset.real.description import Description, LabelColumns, RecordingSource, Scales
from magicsim.dataset.real.labels import LabelTable, at_time, check_times, read_labels
from magicsim.errors import ConfigError


def described(columns: LabelColumns, scale: Scales | None = None) -> Description:
    return Description(
        schema_version=1, columns=columns, scale=scale or Scales(), recordings=(RecordingSource(frames="images"),)
    )


def read(tmp_path: Path, text: str, columns: LabelColumns, scale: Scales | None = None) -> LabelTable:
    (tmp_path / "labels.csv").write_text(text, encoding="utf-8")
    return read_labels(tmp_path / "labels.csv", described(columns, scale), needs_images=True)


def test_names_units_and_signs_are_those_of_the_description(tmp_path: Path):
    columns = LabelColumns(image="file", depth_mm="z", place_mm=("px", "py"), force_n=("a", "b", "c"), contact="on")
    scale = Scales(depth_mm=1000, place_mm=10, force_n=(1, 1, -1))
    found = read(tmp_path, "file, z,px,py,a,b,c,on\n1.png,0.0005,0.1,-0.2,0.3,0,-2,1\n", columns, scale)
    [row] = found.rows
    assert row["image"] == "1.png"
    assert row["depth_mm"] == pytest.approx(0.5)
    assert row["place_mm"][:2] == pytest.approx([1, -2])
    assert math.isnan(row["place_mm"][2])
    assert row["force_n"] == pytest.approx([0.3, 0, 2])
    assert row["contact"] is True
    assert found.known == {"image", "depth_mm", "place_mm", "force_n", "contact"}


def test_one_column_of_force_is_that_of_the_press(tmp_path: Path):
    [row] = read(tmp_path, "image_name,f\na,1.5\n", LabelColumns(force_n="f")).rows
    assert [math.isnan(each) for each in row["force_n"]] == [True, True, False]
    assert row["force_n"][2] == 1.5


def test_empty_cells_are_unknown(tmp_path: Path):
    [row] = read(tmp_path, "image_name,gap,on\na,,\n", LabelColumns(gap_mm="gap", contact="on")).rows
    assert math.isnan(row["gap_mm"])
    assert row["contact"] is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("image_name,force\na,1\n", "unknown column of columns.force_n 'f'.*available: force, image_name"),
        ("image_name,f\na,much\n", "line 2: f = 'much' is not allowed: must be a finite number or empty"),
        ("image_name,f\na,inf\n", "line 2: f = 'inf' is not allowed"),
        ("image_name,f\n", "has a heading and no rows"),
    ],
)
def test_what_cannot_be_read_is_told_with_its_line(tmp_path: Path, text: str, said: str):
    with pytest.raises(ConfigError, match=said):
        read(tmp_path, text, LabelColumns(force_n="f"))


def test_missing_file_is_told(tmp_path: Path):
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        read_labels(tmp_path / "none.csv", described(LabelColumns()), needs_images=True)


def test_numbers_are_interpolated_in_time_and_flags_are_those_of_the_nearer_row(tmp_path: Path):
    columns = LabelColumns(image="t", time_s="t", force_n="f", contact="on")
    found = read(tmp_path, "t,f,on\n0,0,0\n0.1,2,1\n0.5,4,1\n", columns)
    check_times(found)
    row = at_time(found, 0.025, most_gap_s=0.1)
    assert row["force_n"][2] == pytest.approx(0.5)
    assert row["contact"] is False
    assert at_time(found, 0.08, most_gap_s=0.1)["contact"] is True
    assert at_time(found, 0.13, most_gap_s=0.1)["force_n"][2] == 2  # the row after it is too far
    assert math.isnan(at_time(found, 0.3, most_gap_s=0.1)["force_n"][2])


def test_turn_is_interpolated_the_short_way_round(tmp_path: Path):
    columns = LabelColumns(image="t", time_s="t", twist_deg="a")
    found = read(tmp_path, "t,a\n0,170\n0.1,-170\n0.2,-130\n", columns)
    turns = [at_time(found, time_s, most_gap_s=0.2)["twist_deg"] for time_s in (0.025, 0.05, 0.15)]
    assert turns == pytest.approx([175, 180, -150])


def test_an_empty_cell_does_not_empty_its_neighbour(tmp_path: Path):
    columns = LabelColumns(image="t", time_s="t", gap_mm="g")
    found = read(tmp_path, "t,g\n0,\n0.1,2\n0.2,1\n", columns)
    gaps = [at_time(found, time_s, most_gap_s=0.1)["gap_mm"] for time_s in (0.04, 0.06, 0.1, 0.15)]
    assert gaps == pytest.approx([math.nan, 2, 2, 1.5], nan_ok=True)


def test_times_must_be_there_and_rise(tmp_path: Path):
    columns = LabelColumns(image="t", time_s="t")
    with pytest.raises(ConfigError, match="line 3: time_s is missing or falls"):
        check_times(read(tmp_path, "t\n1\n0.5\n", columns))
    with pytest.raises(ConfigError, match=r"columns.time_s is missing"):
        check_times(read(tmp_path, "t\n1\n", LabelColumns(image="t")))
