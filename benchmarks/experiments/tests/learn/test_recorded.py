"""A learned model reads recorded frames that were converted to a dataset."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch")
from dataset.real.drawn import save, write_csv

from learn.test_training import trained
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.writing import write_real
from magicsim.errors import FrameError
from magicsim_experiments.learn.reading import estimate_frames


def test_model_answers_as_for_the_frames_themselves(tmp_path: Path):
    samples, split, _, done = trained()
    (tmp_path / "model.safetensors").write_bytes(done.model)
    rows = []
    for place, row in enumerate(split.test[:3]):
        save(tmp_path / "frames" / f"{place}.png", np.rint(samples.images[row]).astype(np.uint8))
        rows.append({"image_name": f"{place}.png", "fx": 0, "fy": 0, "fz": 0.3})
    save(tmp_path / "untouched.png", np.rint(samples.references[0]).astype(np.uint8))
    write_csv(tmp_path / "labels.csv", rows)
    (tmp_path / "mine.toml").write_text(
        'schema_version = 1\n[[recordings]]\nframes = "frames"\nlabels = "labels.csv"\nuntouched = "untouched.png"\n',
        encoding="utf-8",
    )
    write_real(load_real(tmp_path / "mine.toml"), tmp_path / "set")
    found = list(estimate_frames(tmp_path / "model.safetensors", tmp_path / "set"))
    assert [each.frame for each in found] == [f"episode 0 step {step}" for step in (1, 2, 3)]
    np.testing.assert_allclose([each.values["x"] for each in found], done.answers[:3, 0], atol=0.1)
    write_real(load_real(tmp_path / "mine.toml", ["frames.size_px=[32,40]"]), tmp_path / "larger")
    with pytest.raises(FrameError, match=r"32 x 40 pixels.* frames.size_px = \[16, 20\]"):
        list(estimate_frames(tmp_path / "model.safetensors", tmp_path / "larger"))
