from pathlib import Path

import cv2
import numpy as np
import pytest

from .conftest import Shell
from .small import settings


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["none"], "source 'none' does not exist"),
        (["real", "--frame", "x=real"], "frame = x=real is not allowed: must be K=IMAGES"),
        (["real", "--frame", "3=real"], "frame = 3 is not allowed: must be 0 to 0"),
        (["real", "--blocks", "8"], "blocks = 8 is not allowed: must be two whole numbers"),
        (["real", "--free", "gama"], "did you mean 'gamma'"),
        (["real", "--scene", "rust"], "did you mean 'rest'"),
        (["large"], "large: an image has 10 rows and 10 columns, the rig's camera 32 and 24"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_scene(shell: Shell, tmp_path: Path, arguments: list[str], named: str):
    for name, shape in (("real", (32, 24, 3)), ("large", (10, 10, 3))):
        (tmp_path / name).mkdir()
        assert cv2.imwrite(str(tmp_path / name / "0.png"), np.full(shape, 60, np.uint8))
    assert named in shell.refusal("fit", *arguments, "--out", "mine.toml", *settings())
    assert not list(tmp_path.glob("mine.*"))
