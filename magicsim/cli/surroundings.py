"""What the command line finds around it: streams that are closed or lose their reader, widths, encodings.

Whatever they are, a command does its work, and what it writes to disk does not depend on them.
"""

import codecs
import io
import os
import shutil
import sys
from contextlib import suppress
from typing import Any, TextIO

from magicsim.errors import ConfigError

NARROWEST, WIDEST = 40, 500
"""Columns between which text is laid out: with less, or with 999999999, it takes for ever."""

THREADS_VARIABLE = "NUMBA_NUM_THREADS"


def prepare() -> None:
    """Makes streams, names of files and the terminal's width such that every command can use them."""
    _open_streams()
    _use_utf8()
    _bound_width()
    os.environ["MPLBACKEND"] = "agg"  # nothing is drawn on a screen, and unknown names are refused


def check_threads() -> None:
    """Refuses (`ConfigError`) a number of threads with which numba cannot be imported."""
    threads = os.environ.get(THREADS_VARIABLE, "1")
    if not threads.isdecimal() or int(threads) == 0:
        raise ConfigError(f"{THREADS_VARIABLE} = '{threads}' is not allowed: must be a whole number of at least 1")


class LossyStream:
    """A stream whose reader may go: what can no longer be told does not end the work."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Writes as far as anybody reads."""
        with suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flushes as far as anybody reads."""
        with suppress(OSError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - whatever the stream has
        """Anything else of the stream."""
        return getattr(self._stream, name)


def end_output() -> None:
    """Sends what is left of the result to the null device where its reader has gone or the disk is full."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _open_streams() -> None:
    """Puts the null device where a stream is closed, whose number a file of a result would get otherwise."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_RDWR), number)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w" if number else "r", encoding="utf-8", closefd=False))
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    if not isinstance(sys.stderr, LossyStream):
        sys.stderr = LossyStream(sys.stderr)


def _use_utf8() -> None:
    """Begins anew in Python's UTF-8 mode where names of files could be ASCII alone, as in the locale `C`.

    Nothing of the kind happens where `main` is called by another program.
    """
    words = sys.argv[1:]
    is_ascii = codecs.lookup(sys.getfilesystemencoding()).name == "ascii"
    if is_ascii and words and sys.orig_argv[-len(words) :] == words and sys.executable:
        os.execv(sys.executable, [sys.executable, "-X", "utf8", *sys.orig_argv[1:]])


def _bound_width() -> None:
    """Keeps the width of what is laid out within bounds, whatever the environment or the terminal says."""
    columns, _ = shutil.get_terminal_size()
    bounded = min(max(columns, NARROWEST), WIDEST)
    if bounded != columns or "COLUMNS" in os.environ:
        os.environ["COLUMNS"] = str(bounded)
    if not os.environ.get("LINES", "1").isascii():  # digits of other scripts, of which rich makes no number
        del os.environ["LINES"]
