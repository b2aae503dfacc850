"""Every kind of recording that once gave a silent wrong answer has the right one, or one line that names it."""

from pathlib import Path

import pytest
from laboratory.input_kinds import files, recordings
from laboratory.input_kinds.registry import KINDS, Variation

assert recordings
assert files
VARIATIONS = {
    f"{kind}: {each.name}": each for kind, all_ in KINDS.items() if kind.startswith("recordings") for each in all_
}


@pytest.mark.parametrize("variation", VARIATIONS.values(), ids=VARIATIONS)
def test_answer_is_right_or_one_line(tmp_path: Path, variation: Variation):
    assert variation.attempt(tmp_path) is None
