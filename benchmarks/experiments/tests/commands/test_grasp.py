from pathlib import Path

import pytest
from cli.conftest import Shell


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--episodes", "0"], "--episodes 0 is not allowed: must be 1 to 100000"),
        (["--set", "grip_n=-1"], "task grasp: grip_n = -1 is not allowed"),
        (["--set", "near_mm=[4,1]"], "near_mm: 4, 1 is not allowed: must be the smaller one first"),
        (["--set", "open_gap_mm=45"], "open_gap_mm = 45 is not allowed with item"),
        (["--room", "cellar"], "unknown room"),
        (["--detector", "sharp"], "unknown profile 'sharp'; available: calibrated, facing, published"),
        (["--set", 'items=["pear"]'], "unknown item 'pear'; available: banana, biscuit-packet, orange"),
    ],
)
def test_wrong_input_is_one_line_and_leaves_no_folder(words: list[str], complaint: str, tmp_path: Path, shell: Shell):
    out = tmp_path / "grasps"
    assert complaint in shell.refusal("task", "grasp", "--out", out, *words)
    assert not out.exists()
