"""Files of a folder in the order in which their frames were taken, as far as names tell it."""

import re
from collections.abc import Sequence
from pathlib import Path

from magicsim.config.presets import is_file
from magicsim.detectors.picture import IMAGE_SUFFIXES
from magicsim.detectors.video import Remark
from magicsim.errors import ConfigError

APPLE_DOUBLE = "._"
"""How the names of files begin in which macOS keeps what other disks cannot (RFC 1740)."""
_NUMBERS = re.compile(r"(\d+)")
_DECIMAL = re.compile(r"\d[.,]\d")


def image_files(folder: Path, remark: Remark) -> list[Path]:
    """Images of a folder by the numbers in their names: `frame_2.png` comes before `frame_10.png`.

    Raises:
        ConfigError: There is none, or numbers with a decimal point do not tell which order is meant.
    """
    copies = sorted(each.name for each in folder.glob(f"{APPLE_DOUBLE}*") if each.suffix.lower() in IMAGE_SUFFIXES)
    if copies:
        remark(f"'{folder}': {len(copies)} file(s) of macOS without a picture are passed over, such as '{copies[0]}'")
    files = listed_images(folder)
    if not files:
        raise ConfigError(f"source folder '{folder}' holds no image ({', '.join(IMAGE_SUFFIXES)})")
    ordered = sorted(files, key=lambda each: by_number(each.name))
    if ordered == files:
        return files
    place = next(place for place, (one, other) in enumerate(zip(files, ordered, strict=True)) if one != other)
    first, second = ordered[place].name, files[place].name
    if not is_numbered([each.stem for each in files]):
        raise ConfigError(
            f"'{folder}': '{first}' may come before or after '{second}'; fill up the numbers in their names with zeros"
        )
    remark(f"'{folder}': frames are in the order of the numbers in their names, '{first}' before '{second}'")
    return ordered


def listed_images(folder: Path) -> list[Path]:
    """Images of a folder by the text of their names."""
    files = (each for each in folder.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES and each.is_file())
    return sorted(each for each in files if not each.name.startswith(APPLE_DOUBLE))


def by_number(name: str) -> tuple[list[str | int], str]:
    """Sorts names by their text, but for numbers, which count as such."""
    parts = _NUMBERS.split(name)
    return [int(each) if number % 2 else each for number, each in enumerate(parts)], name


def is_numbered(stems: Sequence[str]) -> bool:
    """Whether every name has a number, and none a decimal point, so that the numbers tell an order."""
    return all(_NUMBERS.search(each) and not _DECIMAL.search(each) for each in stems)


def image_path(folder: Path, name: str) -> Path | None:
    """File that a table means by a name, whose ending may be missing; None where there is none."""
    candidates = [folder / name]
    if Path(name).suffix.lower() not in IMAGE_SUFFIXES:
        candidates += [folder / f"{name}{ending}" for ending in IMAGE_SUFFIXES]
    return next((path for path in candidates if name and is_file(path)), None)
