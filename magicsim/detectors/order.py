"""Files of a folder in the order in which their frames were taken, as far as names tell it."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from magicsim.config.presets import is_file
from magicsim.detectors.picture import IMAGE_SUFFIXES
from magicsim.detectors.video import Remark
from magicsim.errors import ConfigError

HIDDEN = "."
"""How the names of files begin that are hidden, such as those in which macOS keeps what other disks cannot (`._`, RFC
1740), and what programs have not finished."""
_NUMBERS = re.compile(r"(\d+)")
_DECIMAL = re.compile(r"\d[.,]\d")


def image_files(folder: Path, remark: Remark) -> list[Path]:
    """Images of a folder by the numbers in their names: `frame_2.png` comes before `frame_10.png`.

    Raises:
        ConfigError: There is none, or one is a link to nothing, two have one name with two endings, or numbers with a
            decimal point do not tell which order is meant.
    """
    hidden = sorted(each.name for each in _named_images(folder) if each.name.startswith(HIDDEN))
    if hidden:
        what = "file(s) of macOS without a picture" if hidden[0].startswith("._") else "hidden file(s)"
        remark(f"'{folder}': {len(hidden)} {what} are passed over, such as '{hidden[0]}'")
    files = listed_images(folder)
    _check_twins(folder, files)
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
    found = sorted(each for each in _named_images(folder) if not each.name.startswith(HIDDEN))
    if lost := [each.name for each in found if each.is_symlink() and not each.exists()]:
        more = f", one of {len(lost)}" if len(lost) > 1 else ""
        raise ConfigError(f"'{folder}': '{lost[0]}'{more} is a link to a file that is not there: fetch the data first")
    return [each for each in found if is_file(each)]


def _named_images(folder: Path) -> Iterator[Path]:
    return (each for each in folder.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES)


def _check_twins(folder: Path, files: Sequence[Path]) -> None:
    """Refuses a picture that is there twice: with another ending, or as a link to another one of the folder."""
    seen: dict[str | Path, str] = {}
    for each in files:
        for key in (each.stem, each.resolve()):
            if (other := seen.setdefault(key, each.name)) != each.name:
                raise ConfigError(f"'{folder}': '{other}' and '{each.name}' are one picture: leave one of them")


def by_number(name: str) -> tuple[list[str | int], str]:
    """Sorts names by their text, but for numbers, which count as such."""
    parts = _NUMBERS.split(name)
    return [int(each) if number % 2 else each for number, each in enumerate(parts)], name


def is_numbered(stems: Sequence[str]) -> bool:
    """Whether every name has a number, and none a decimal point, so that the numbers tell an order."""
    return all(_NUMBERS.search(each) and not _DECIMAL.search(each) for each in stems)


def image_path(folder: Path, name: str) -> Path | None:
    """File that a table means by a name, whose ending may be missing; None where there is none.

    Raises:
        ConfigError: There are several of that name with other endings.
    """
    candidates = [folder / name]
    if Path(name).suffix.lower() not in IMAGE_SUFFIXES:
        candidates += [folder / f"{name}{ending}" for ending in IMAGE_SUFFIXES]
    found = [path for path in candidates if name and is_file(path)]
    _check_twins(folder, found)
    return found[0] if found else None
