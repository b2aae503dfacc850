"""The command that runs the detectors: `detect`."""

import sys
from pathlib import Path

from magicsim.cli.app import Json, Seed, Settings, app
from magicsim.errors import ConfigError


@app.command
def detect(
    source: Path, *, reference: Path, profile: str = "calibrated", seed: Seed = None, settings: Settings = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Run the detectors on an image or a folder of images."""
    from magicsim.detectors.cli import as_json, as_table
    from magicsim.detectors.offline import detect_sources

    del seed  # nothing here is random; the option exists on every command
    if settings:
        msg = f"--set {settings[0]} is not allowed with detect; write a profile file and name it with --profile"
        raise ConfigError(msg)
    verdicts = detect_sources(source, reference, profile)
    sys.stdout.write((as_json(verdicts) if json else as_table(verdicts)).rstrip() + "\n")
