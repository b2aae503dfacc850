"""The one reader of TOML and of JSON text: whatever is wrong with a file is one line that names it.

A file that is too large is refused before it is read, and one that is nested too deeply before anything walks through
it.
"""

import json
import math
import re
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from magicsim.errors import ConfigError

MAX_TOML_BYTES = 4_000_000
"""Largest TOML file; one with 100,000 keyframes has about 3 MB."""
MAX_JSON_BYTES = 256_000_000
"""Largest JSON file; the manifest of a million files has about 200 MB."""
MAX_DEPTH = 32
"""Deepest nesting of tables and lists; what magicsim reads and writes has less than ten."""
MAX_DOTS = 200
"""Dots in one key above which it is not parsed: the time that takes grows with their square."""
_KEY = re.compile(r"[\w\s.\"'\[-]*$")
"""Ends a text with what may be a key of TOML."""


def read_toml(path: Path) -> dict[str, Any]:
    """Parses a TOML file.

    Raises:
        ConfigError: Not readable, larger than `MAX_TOML_BYTES`, not UTF-8, not valid TOML, or nested too deeply.
    """
    return parse_toml(_read(path, "TOML", MAX_TOML_BYTES), source=str(path))


def read_json(path: Path) -> Any:  # noqa: ANN401 - whatever the file holds
    """Parses a JSON file; a `ConfigError` says why not, as `read_toml` does."""
    return parse_json(_read(path, "JSON", MAX_JSON_BYTES), source=str(path))


def parse_toml(text: str, *, source: str) -> dict[str, Any]:
    """Parses a TOML text; `ConfigError` where it is not valid, or nested too deeply."""
    if any(_has_long_key(line) for line in text.splitlines() if line.count(".") > MAX_DOTS):
        raise ConfigError(_too_deep(source))
    result: dict[str, Any] = _parsed(tomllib.loads, text, "TOML", source)
    return result


def parse_json(text: str, *, source: str) -> Any:  # noqa: ANN401 - whatever the text holds
    """Parses a JSON text; `ConfigError` where it is not valid, or nested too deeply."""
    return _parsed(json.loads, text, "JSON", source)


def _read(path: Path, kind: str, most: int) -> str:
    try:
        size = path.stat().st_size
        if size > most:
            raise ConfigError(f"{path} has {size} bytes: a {kind} file may have at most {most}")
        return path.read_text(encoding="utf-8-sig")  # editors may mark the beginning
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path} is not valid {kind}: not a text in UTF-8") from None


def _parsed(parse: Callable[[str], Any], text: str, kind: str, source: str) -> Any:  # noqa: ANN401 - as above
    try:
        values = parse(text)
    except RecursionError:
        raise ConfigError(_too_deep(source)) from None
    except ValueError as error:  # wrong syntax, or a whole number with thousands of digits
        raise ConfigError(f"{source} is not valid {kind}: {error}") from None
    if is_nested_deeper(values, MAX_DEPTH):
        raise ConfigError(_too_deep(source))
    return values


def is_nested_deeper(value: object, depth: int) -> bool:
    """Whether tables and lists are nested more often than so; a plain value is nested 0 times."""
    level = [value]
    for _ in range(depth + 1):
        inner = [each.values() if isinstance(each, dict) else each for each in level if isinstance(each, dict | list)]
        if not inner:
            return False
        level = [each for values in inner for each in values]
    return True


def _too_deep(source: str) -> str:
    return f"{source} is nested too deeply: at most {MAX_DEPTH} tables and lists inside each other are allowed"


def _has_long_key(line: str) -> bool:
    """Whether a key of a line has more than `MAX_DOTS` dots, by what stands before each `=` or in a heading."""
    heading = [line.rstrip("] \t")] if line.lstrip().startswith("[") else []
    for part in [*line.split("=")[:-1], *heading]:
        key = _KEY.search(part[-(1 << 16) :])
        if key is not None and key.group().count(".") > MAX_DOTS:
            return True
    return False


def without_nan(value: Any) -> Any:  # noqa: ANN401 - any nesting that JSON has
    """The value with None where a number is none or infinite, for which JSON has no word."""
    return each_leaf(value, lambda each: None if isinstance(each, float) and not math.isfinite(each) else each)


def each_leaf(value: Any, change: Callable[[Any], Any]) -> Any:  # noqa: ANN401 - any nesting that JSON has
    """The value with what is neither a table nor a list in it changed."""
    if isinstance(value, Mapping):
        return {key: each_leaf(each, change) for key, each in value.items()}
    return [each_leaf(each, change) for each in value] if isinstance(value, list | tuple) else change(value)


def dotted(value: object, name: str = "") -> dict[str, object]:
    """What is neither a table nor a list in a document, by its dotted key; places of lists are numbers."""
    if not isinstance(value, Mapping | list):
        return {name: value}
    items = value.items() if isinstance(value, Mapping) else enumerate(value)
    return {key: each for part, inner in items for key, each in dotted(inner, f"{name}.{part}".lstrip(".")).items()}
