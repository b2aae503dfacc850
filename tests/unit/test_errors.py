import logging
import pickle

import pytest

from magicsim.cli.app import lines_of
from magicsim.cli.entry import _OneLine
from magicsim.errors import LINE_LENGTH, ConfigError, ConvergenceError, one_line, shortened, unknown_choice, visible


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain", "plain"),
        ("\x1b[31mred\x1b[0m", r"\x1b[31mred\x1b[0m"),
        ("a\u202eb", r"a\u202eb"),
        ("a\nb\tc\x00", r"a\nb\tc\x00"),
        ("\u200b\ufeff\u2028", r"\u200b\ufeff\u2028"),
        ("\udcff", r"\udcff"),
        ("5\u00a0mm, 90°, Öl, 触覚, 😀", "5\u00a0mm, 90°, Öl, 触覚, 😀"),
    ],
)
def test_what_hides_is_spelt_out_and_nothing_else(text: str, shown: str):
    assert visible(text) == shown
    assert visible(shown) == shown


def test_long_text_keeps_its_head_and_its_tail():
    text = "field = " + "x" * 100_000 + " is not allowed: must be a number"
    line = one_line(text)
    assert len(line) <= LINE_LENGTH
    assert line.startswith("field = xxx")
    assert line.endswith("must be a number")
    assert "characters ..." in line
    assert one_line(line) == line


@pytest.mark.parametrize("length", [50, 80, 479, 480, 481, 10_000])
@pytest.mark.parametrize("letter", ["x", "\u202e"])
def test_line_is_never_longer_than_allowed(length: int, letter: str):
    assert len(one_line(letter * length)) <= LINE_LENGTH
    assert len(shortened(letter * length, 60)) <= 60


def test_every_error_is_one_printable_line_and_survives_another_process():
    error = ConvergenceError("no\x1b answer\n" * 1000)
    assert str(error).isprintable()
    assert len(str(error)) <= LINE_LENGTH
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back)) == (ConvergenceError, str(error))


def test_nested_errors_stay_bounded_and_say_what_is_allowed():
    error = ConfigError(unknown_choice("object kind", "y" * 100_000, ["sphere", "box"]))
    outer = ConfigError(f"suite.toml: {error}")
    assert len(str(outer)) < 200
    assert str(outer).endswith("available: box, sphere")


def test_warning_is_one_line_without_the_traceback_of_a_library():
    record = logging.LogRecord("trimesh", logging.WARNING, "", 0, "bad %s", ("\n\x1b" * 400,), None)
    record.exc_info = (ValueError, ValueError("inside"), None)
    line = _OneLine("magicsim: %(message)s").format(record)
    assert line.isprintable()
    assert len(line) <= LINE_LENGTH
    assert "inside" not in line


def test_printed_results_show_what_hides_in_a_name():
    assert list(lines_of({"out": "a\x1b[2Jb\u202e"})) == [r"out: a\x1b[2Jb\u202e"]
