"""Command line of the detectors where only NumPy and OpenCV are installed."""

import argparse
import json
import logging
import sys
from collections.abc import Sequence
from typing import NoReturn

import cv2

from magicsim.detectors.offline import detect_sources
from magicsim.detectors.verdict import Verdict
from magicsim.errors import ConfigError, MagicsimError

EXIT_WRONG_INPUT = 2
"""Exit status for an argument, a file or a frame that cannot be used."""

_NUMBERS = ("entropy", "correlation", "similarity", "p_approach", "p_noise", "p_touch")
_WORDS = ("proximity", "contact", "combined")


class _Parser(argparse.ArgumentParser):
    """Reports a wrong argument like every other error: one line."""

    def error(self, message: str) -> NoReturn:
        """Raise instead of printing the usage."""
        raise ConfigError(message)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: What follows the command's name; the process's own by default.

    Returns:
        The exit status: 0, or 2 after one line on standard error.
    """
    logging.basicConfig(format="%(levelname)s: %(message)s", stream=sys.stderr)
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # A broken image is reported once, by us.
    try:
        options = _parser().parse_args(arguments)
        verdicts = detect_sources(options.source, options.reference, options.profile)
    except MagicsimError as error:
        sys.stderr.write(f"error: {' '.join(str(error).split())}\n")
        return EXIT_WRONG_INPUT
    sys.stdout.write(as_json(verdicts) if options.json else as_table(verdicts))
    return 0


def as_json(verdicts: Sequence[Verdict]) -> str:
    """One JSON object with the list `frames`, and a final newline."""
    return json.dumps({"frames": [each.as_dict() for each in verdicts]}, allow_nan=False) + "\n"


def as_table(verdicts: Sequence[Verdict]) -> str:
    """One line of text for each verdict below a heading."""
    width = max((len(each.source or "") for each in verdicts), default=0)
    width = max(width, len("source"))
    head = [f"{'source':<{width}}"]
    head += [f"{name:>11}" for name in _NUMBERS] + [f"{name:<11}" for name in _WORDS]
    lines = ["  ".join(head).rstrip()]
    for each in verdicts:
        numbers = [f"{getattr(each, name):>11.4f}" for name in _NUMBERS]
        words = [f"{getattr(each, name):<11}" for name in _WORDS]
        lines.append("  ".join([f"{each.source or '':<{width}}", *numbers, *words]).rstrip())
    return "\n".join(lines) + "\n"


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="python -m magicsim.detectors",
        description="Proximity and contact verdicts for frames of a mini-MagicTac sensor.",
    )
    parser.add_argument("source", metavar="SOURCE", help="image or folder of images to judge")
    parser.add_argument(
        "--reference", metavar="SOURCE", required=True, help="images of the untouched sensor, in their order"
    )
    parser.add_argument("--profile", metavar="NAME", default="published", help="profile name or TOML file")
    parser.add_argument("--json", action="store_true", help="print one JSON object on standard output")
    return parser
