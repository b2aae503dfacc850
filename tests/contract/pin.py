"""Writes `pins.json` anew: `python -m tests.contract.pin [frames] [forces] [keys]`; for new physics alone."""

import json
import os
import sys
import tempfile
from pathlib import Path

from tests.contract import cases

PINS = Path(__file__).with_name("pins.json")
PARTS = ("frames", "forces", "keys")


def frames(folder: Path) -> dict[str, object]:
    """Digests of all frames."""
    found = {}
    for number, (case, make) in enumerate(cases.FRAMES.items()):
        own = folder / f"case-{number}"
        own.mkdir()
        found[case] = dict(make(own))
    return found


def keys(folder: Path) -> dict[str, object]:
    """Keys that each command prints."""
    found = {}
    for command in cases.COMMANDS:
        if command == "real":
            cases.write_recording(folder)
        found[command] = cases.printed_keys(command, folder)
    return found


def main(parts: list[str]) -> None:
    """Makes the parts that are asked for, all by default, and writes each as soon as it is there."""
    os.environ["MAGICSIM_CACHE"] = "off"  # as in tests
    pins = json.loads(PINS.read_text(encoding="utf-8")) if PINS.exists() else {}
    pins["made_on"] = cases.processor()
    for part in parts or PARTS:
        with tempfile.TemporaryDirectory() as name:
            pins[part] = {"frames": frames, "forces": lambda _: cases.forces(), "keys": keys}[part](Path(name))
        PINS.write_text(json.dumps(pins, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
