"""Reading and writing detector profiles as TOML."""

import dataclasses
import json
import os
import secrets
from pathlib import Path

from magicsim.config.documents import read_toml
from magicsim.config.presets import find_preset
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.errors import ConfigError, OutputError, unknown_choice


def load_profile(name_or_path: str | Path) -> DetectorProfile:
    """Read a profile by its shipped name (`published`) or from the user's own TOML file.

    Keys that the file leaves out keep their published values.

    Raises:
        PresetError: There is no such profile.
        ConfigError: Not valid TOML, an unknown key, or a value of the wrong type or out of range; the line
            names the file, the field, the value and what is allowed.
    """
    path = find_preset("profile", name_or_path)
    values = read_toml(path)
    names = {each.name for each in dataclasses.fields(DetectorProfile)}
    for key in values:
        if key not in names:
            msg = f"profile file '{path}': {unknown_choice('key', key, names)}"
            raise ConfigError(msg)
    try:
        return DetectorProfile(**values)
    except ConfigError as error:
        msg = f"profile file '{path}': {error}"
        raise ConfigError(msg) from error


def save_profile(profile: DetectorProfile, path: str | Path, *, comment: str) -> None:
    """Write a profile as TOML that `load_profile` reads back unchanged.

    Args:
        profile: What to write.
        path: The file; replaced whole or not at all.
        comment: Opening comment that says what the profile describes; may have several lines.

    Raises:
        ConfigError: The comment is empty.
        OutputError: The file cannot be written.
    """
    if not comment.strip():
        msg = "comment is empty; a profile file opens with a comment that says what it describes"
        raise ConfigError(msg)
    lines = [f"# {line}".rstrip() for line in comment.strip().splitlines()]
    # JSON's numbers and short words are TOML's too, and Python writes floats so that they read back exactly.
    lines += [f"{name} = {json.dumps(value)}" for name, value in dataclasses.asdict(profile).items()]
    target = Path(path)
    partial = target.with_name(f".{target.name}.{secrets.token_hex(8)}.partial")
    try:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
        os.replace(partial, target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        msg = f"profile file '{target}' cannot be written: {error.strerror}"
        raise OutputError(msg) from error
