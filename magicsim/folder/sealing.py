"""JSON that tells whether it has changed since it was written: its own hash stands in it."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

SEAL = "sha256"
"""Key of the hash, the last one."""


def sealed(values: Mapping[str, Any], *, indent: int | None = 1) -> bytes:
    """An object as text that ends with a newline, with the SHA-256 of the same text in which that key is empty.

    Args:
        values: The object, without the key or with an earlier hash.
        indent: Spaces of a level; None for one line.
    """
    plain = {key: value for key, value in values.items() if key != SEAL}
    digest = hashlib.sha256(_text(plain | {SEAL: ""}, indent)).hexdigest()
    return _text(plain | {SEAL: digest}, indent)


def is_sealed(text: bytes, *, indent: int | None = 1) -> bool:
    """Whether a text is byte for byte what `sealed` makes of its content."""
    try:
        values = json.loads(text)
        return isinstance(values, dict) and sealed(values, indent=indent) == text
    except (ValueError, RecursionError):
        return False


def _text(values: Mapping[str, Any], indent: int | None) -> bytes:
    return (json.dumps(values, indent=indent) + "\n").encode()
