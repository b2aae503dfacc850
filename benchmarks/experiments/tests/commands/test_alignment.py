from pathlib import Path

import pytest
from cli.conftest import Shell


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "--model is missing: 'magicsim study alignment --out DIR' makes one"),
        (["--episodes", "0"], "--episodes 0 is not allowed: must be 1 to 100000"),
        (["--model", "m", "--set", "grip_n=-1"], "task alignment: grip_n = -1 is not allowed"),
    ],
)
def test_wrong_input_is_one_line_and_leaves_no_folder(words: list[str], complaint: str, tmp_path: Path, shell: Shell):
    out = tmp_path / "alignments"
    assert complaint in shell.refusal("task", "alignment", "--out", out, *words)
    assert not out.exists()
