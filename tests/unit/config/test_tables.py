"""Tables of comma-separated values: right numbers, or one line that names what is not clear."""

import math
from pathlib import Path

import pytest

from magicsim.config.tables import Table, read_table
from magicsim.errors import ConfigError


def table(tmp_path: Path, text: str, encoding: str = "utf-8") -> Table:
    path = tmp_path / "labels.csv"
    path.write_bytes(text.encode(encoding))
    return read_table(path)


def lines(tmp_path: Path, text: str, *names: str):
    return list(table(tmp_path, text).lines(names))


@pytest.mark.parametrize(
    ("cell", "value"), [("1", 1), (" -0.5 ", -0.5), ("+.5", 0.5), ("2.", 2), ("1e-3", 1e-3), ("1.5E2", 150)]
)
def test_number_is_read(tmp_path: Path, cell: str, value: float):
    assert [each.number("f") for each in lines(tmp_path, f"f,g\n{cell},\n", "f")] == [value]


@pytest.mark.parametrize("cell", ["", "  ", "nan", "NaN"])
def test_empty_cell_is_unknown(tmp_path: Path, cell: str):
    [line] = lines(tmp_path, f"f,g\n{cell},\n", "f")
    assert math.isnan(line.number("f"))


@pytest.mark.parametrize("cell", ["1_0", "0x10", "1e999", "inf", "-", "1.0N", "\u0661", '"0,5"', "1 000"])
def test_text_that_is_no_number_is_refused(tmp_path: Path, cell: str):
    [line] = lines(tmp_path, f"f,g\n{cell},\n", "f")
    with pytest.raises(
        ConfigError, match=r"labels.csv, line 2: f = '.*' is not allowed: must be a finite number or empty"
    ):
        line.number("f")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,f\nx,0,5\n", "line 2: 3 cells; must be 2, as in the heading; a number has a decimal point"),
        ("a,f\nx,1\n\ny\n", "line 4: 1 cells; must be 2, as in the heading"),
        ("a,f,f\nx,1,2\n", "2 columns are called 'f'; must be one"),
        ('a,f\n"x,1\ny,2\n', "cannot be read: unexpected end of data; must be a CSV file in UTF-8"),
    ],
)
def test_table_that_is_not_clear_is_one_line(tmp_path: Path, text: str, said: str):
    with pytest.raises(ConfigError, match=said) as caught:
        lines(tmp_path, text, "a", "f")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("mark", "name"), [(";", "';'"), ("\t", "tabs"), ("|", r"'\|'"), (" ", "spaces")])
def test_other_delimiter_is_named(tmp_path: Path, mark: str, name: str):
    with pytest.raises(ConfigError, match=f"cells are separated by {name}; must be commas"):
        table(tmp_path, f"a{mark}f\nx{mark}1\n").check_delimiter()


def test_text_of_another_encoding_is_refused(tmp_path: Path):
    with pytest.raises(ConfigError, match="must be a CSV file in UTF-8"):
        table(tmp_path, "a,f\nx,1\n", "utf-16")


def test_twin_that_nobody_asks_for_harms_nothing(tmp_path: Path):
    assert [each.text("a") for each in lines(tmp_path, "a,n,n\nx,1,2\n", "a")] == ["x"]
