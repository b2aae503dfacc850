"""Command line of the detectors where only NumPy and OpenCV are installed: `python -m magicsim.detectors`."""

import argparse
import logging
import sys
from collections.abc import Sequence
from typing import NoReturn

from magicsim.detectors.offline import write_verdicts
from magicsim.detectors.video import quiet_opencv
from magicsim.errors import ConfigError, MagicsimError, one_line

EXIT_WRONG_INPUT = 2
"""Exit status for an argument, a file or a frame that cannot be used."""
EXIT_STOPPED = 130
"""Exit status after an interruption, as of shells."""


class _Parser(argparse.ArgumentParser):
    """Reports a wrong argument like every other error: one line."""

    def error(self, message: str) -> NoReturn:
        """Raise instead of printing the usage."""
        raise ConfigError(message)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its status: 0, 2 after one line on standard error, or 130 when interrupted."""
    logging.basicConfig(format="%(levelname)s: %(message)s", stream=sys.stderr)
    try:
        options = _parser().parse_args(arguments)
        with quiet_opencv():  # a broken image is reported once, by us
            write_verdicts(
                sys.stdout, options.source, options.reference, options.profile, frames=options.frames,
                touches=options.touches, grasp=options.grasp, as_json=options.json,
            )  # fmt: skip
    except (MagicsimError, OSError) as error:  # or a name that is too long, a folder that may not be read
        sys.stderr.write(f"error: {error if isinstance(error, MagicsimError) else one_line(str(error))}\n")
        return EXIT_WRONG_INPUT
    except KeyboardInterrupt:
        return EXIT_STOPPED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="python -m magicsim.detectors",
        description="Proximity and contact verdicts for frames of a mini-MagicTac sensor.",
    )
    parser.add_argument("source", metavar="SOURCE", help="image, folder of images, video or camera index to judge")
    parser.add_argument(
        "--reference", metavar="SOURCE", required=True, help="the untouched sensor, from the same kinds of source"
    )
    parser.add_argument(
        "--touches", metavar="SOURCE", help="the sensor's own first touches, for a profile in units of rest"
    )
    parser.add_argument("--profile", metavar="NAME", default="published", help="profile name or TOML file")
    parser.add_argument("--frames", metavar="N", type=int, help="judge at most N frames; a camera never ends")
    parser.add_argument("--grasp", action="store_true", help="run the grasp state machine over the frames too")
    parser.add_argument("--json", action="store_true", help="print one JSON object on standard output")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
