import json
import random

import pytest

from magicsim.folder.listing import is_sealed, sealed

VALUES = {"b": [1, 2.5, None], "a": {"ä": True}, "sha256": "of before"}


@pytest.mark.parametrize("indent", [None, 1])
def test_every_flipped_bit_and_every_other_byte_is_noticed(indent: int | None):
    text = sealed(VALUES, indent=indent)
    assert is_sealed(text, indent=indent)
    assert json.loads(text)["b"] == VALUES["b"]
    for place in range(8 * len(text)):
        changed = bytearray(text)
        changed[place // 8] ^= 1 << place % 8
        assert not is_sealed(bytes(changed), indent=indent)
    for other in (text + b"\n", text[:-1], b" " + text, text.replace(b"1", b"1.0", 1), b"", b"[]", b"{}"):
        assert not is_sealed(other, indent=indent)


def test_same_content_has_the_same_bytes():
    assert sealed(VALUES) == sealed({**VALUES, "sha256": ""})
    assert sealed(VALUES) != sealed({**VALUES, "b": random.Random(1).random()})
