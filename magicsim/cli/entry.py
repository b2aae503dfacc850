"""What the installed command runs: parse, call, and report an error as one line.

The command modules are imported for their registration alone.
"""

import logging
import os
import signal
import sys

from cyclopts import CycloptsError
from cyclopts.exceptions import UnknownCommandError

from magicsim.cli import dataset, evaluate, fit, info, press, simulate  # noqa: F401
from magicsim.cli.app import app
from magicsim.cli.surroundings import check_threads, end_output, prepare
from magicsim.config.presets import COMMANDS, EXPERIMENTS, extensions, missing_experiments
from magicsim.errors import ConfigError, MagicsimError, one_line, unknown_choice
from magicsim.folder import check_current_folder
from magicsim.light.variant import VARIANT_VARIABLE, VARIANTS

for _name, _point in extensions(COMMANDS).items():
    app.command(_point.load(), name=_name)

EARLIER = {
    "demo": ("simulate", "demo"),
    "plan": ("simulate", "plan"),
    "durometer": ("press", "durometer"),
    "calibrate": ("fit", "profile"),
    "calibration": ("info", "camera"),
    "real": ("dataset", "import"),
    "list": ("info", "list"),
    "schema": ("info", "schema"),
    "doctor": ("info", "doctor"),
    "completion": ("info", "completion"),
}
"""Earlier names of commands, which still work, and what they are now."""
FITS = ("optics", "profile")
"""What `fit` fits; where its first word is none of these, as earlier, it fits `optics`."""
STOPPED, UNREAD, TERMINATED = 130, 141, 143
"""Exit codes after SIGINT, SIGPIPE and SIGTERM, as a shell gives them."""


def main() -> None:
    """Entry point: errors are one line on stderr and exit code 2; who ends it finds no half-written results."""
    prepare()
    # as any other error would: what is being written is cleared away
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(TERMINATED))
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_OneLine("magicsim: %(message)s"))
    logging.basicConfig(level=logging.WARNING, handlers=[handler])
    try:
        check_current_folder()
        check_threads()
        asked = _with_variant(sys.argv[1:])
        words = present_words(asked)
        _call(words)
        if words != asked:  # not beside an error, which is one line
            sys.stderr.write(f"magicsim: '{asked[0]}' is '{' '.join(words[:2])}' now\n")
    except UnknownCommandError as error:
        word = (error.unused_tokens or [""])[0]
        choices = [name for name in app if name[0] != "-" and app[name].show]
        _fail(missing_experiments(word) if word in EXPERIMENTS else unknown_choice("command", word, choices))
    except CycloptsError as error:
        _fail(" ".join(str(error).split()))
    except MagicsimError as error:
        _fail(str(error))
    except BrokenPipeError:  # whoever read the result, such as `head`, has gone: nothing more can be told
        end_output()
        sys.exit(UNREAD)
    except UnicodeError as error:  # a name with bytes that are no text, or of which the locale has no letters
        _fail(str(error))
    except OSError as error:  # a name that is too long, links in a circle, a folder that may not be read
        end_output()
        where = f"'{error.filename}': " if error.filename is not None else ""
        _fail(f"{where}{error.strerror or error}")
    except KeyboardInterrupt:
        sys.stderr.write("magicsim: stopped\n")
        sys.exit(STOPPED)


def _call(words: list[str]) -> None:
    """Runs a command; returns where it ended well, and its result is told."""
    try:
        app(words, exit_on_error=False, print_error=False)
    except SystemExit as stop:
        if stop.code:
            raise
    finally:
        sys.stdout.flush()


def present_words(words: list[str]) -> list[str]:
    """The words of a command line with the command's present name in place of an earlier one."""
    first, rest = words[:1], words[1:]
    if first and first[0] in EARLIER:
        return [*EARLIER[first[0]], *rest]
    if first == ["fit"] and rest and rest[0] not in (*FITS, "--help", "-h"):
        return ["fit", "optics", *rest]
    return words


def _with_variant(words: list[str]) -> list[str]:
    """The words without `--variant NAME`, which every command takes: it must be known before Mitsuba is loaded."""
    rest = list(words)
    for place, word in enumerate(words):
        name, equals, value = word.partition("=")
        if name == "--variant" and (equals or place + 1 < len(words)):
            chosen = value if equals else words[place + 1]
            if chosen not in VARIANTS:
                raise ConfigError(unknown_choice("variant", chosen, VARIANTS))
            os.environ[VARIANT_VARIABLE] = chosen
            del rest[place : place + (1 if equals else 2)]
            break
    return rest


def _fail(message: str) -> None:
    sys.stderr.write(f"magicsim: {one_line(message)}\n")
    sys.exit(2)


class _OneLine(logging.Formatter):
    """Warnings, as errors, are one printable line."""

    def format(self, record: logging.LogRecord) -> str:
        """The message, without a traceback that a library may have added."""
        record.message = record.getMessage()
        return one_line(self.formatMessage(record))
