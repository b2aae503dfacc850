"""What people read instead of JSON."""

from magicsim.cli.app import lines_of


def test_a_value_is_a_line_and_nothing_is_a_dash():
    values = {"force_n": 1.23456789, "converged": True, "note": None, "size": (240, 320), "problems": []}
    assert list(lines_of(values)) == [
        "force_n: 1.23457", "converged: yes", "note: -", "size: 240, 320", "problems: none",
    ]  # fmt: skip


def test_rows_of_a_matrix_stay_apart():
    assert list(lines_of({"matrix": ((1.0, 0.0), (0.0, 1.0))})) == ["matrix: (1, 0), (0, 1)"]


def test_a_short_thing_is_a_line_of_a_list_and_a_wide_one_a_row_below_a_head():
    short = [{"stage": "grid", "reason": "cell_mm is 0"}]
    assert list(lines_of({"left_out": short})) == ["left_out:", "  grid: cell_mm is 0"]
    wide = [{"a": 1, "b": 2.5, "c": None, "dd": "x"}, {"a": 10, "b": 0.25, "c": False, "dd": "y"}]
    assert list(lines_of({"rows": wide})) == [
        "rows:",
        "  a   b     c   dd",
        "  1   2.5   -   x",
        "  10  0.25  no  y",
    ]
