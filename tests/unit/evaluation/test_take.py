import logging
from pathlib import Path

import numpy as np
import pytest

from evaluation.synthetic import make_suite, make_take, write_suite
from magicsim.evaluation.footage import film_case
from magicsim.evaluation.suite import load_suite
from magicsim.evaluation.take import cached_take, list_cases, read_take, take_key, write_take


def test_take_is_read_back_as_it_was_written(tmp_path: Path):
    suite, cache = make_suite(tmp_path, objects=1)
    case = list_cases(suite)[0]
    written, read = make_take(case), cached_take(case.scene, cache)
    for name in written.__slots__:
        assert np.array_equal(getattr(written, name), getattr(read, name), equal_nan=name == "gap_mm")


def test_key_follows_everything_that_is_rendered_and_nothing_else(tmp_path: Path):
    path = write_suite(tmp_path, objects=1)
    key = take_key(list_cases(load_suite(path))[0].scene)
    assert key == take_key(list_cases(load_suite(path, ["seed=7", "resamples=200"]))[0].scene)
    for change in ("render.samples=9", "design.skin_mm=0.7", "rig.lens.thickness_mm=1.0", "frames_per_second=30"):
        assert key != take_key(list_cases(load_suite(path, [change]))[0].scene)


def test_interrupted_write_leaves_nothing_under_the_final_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    suite, _ = make_suite(tmp_path, objects=1)
    take = make_take(list_cases(suite)[0])

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("magicsim.evaluation.take.os.fsync", stop)
    with pytest.raises(KeyboardInterrupt):
        write_take(tmp_path / "new" / "take.npz", take)
    assert list((tmp_path / "new").iterdir()) == []


def test_damaged_take_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture):
    suite, cache = make_suite(tmp_path, objects=1)
    case = list_cases(suite)[0]
    file = cache / f"{take_key(case.scene)}.npz"
    file.write_bytes(file.read_bytes()[:2000])
    monkeypatch.setattr("magicsim.evaluation.take.film_take", lambda _: make_take(case))
    with caplog.at_level(logging.WARNING):
        assert cached_take(case.scene, cache).radiance.shape[-1] == 3
    assert "is damaged" in caplog.text
    assert read_take(file).state.shape == make_take(case).state.shape


def test_noises_share_a_take_and_differ_in_their_frames(tmp_path: Path):
    suite, cache = make_suite(tmp_path, objects=1)
    quiet, loud = film_case(list_cases(suite)[0], suite, cache)
    assert quiet.tag.take == loud.tag.take
    spread = [float(np.stack(list(each.images.references())).std(0).mean()) for each in (quiet, loud)]
    assert spread[1] > 1.5 * spread[0] > 0


def test_frames_repeat_for_a_seed_and_differ_for_another(tmp_path: Path):
    suite, cache = make_suite(tmp_path, objects=1)
    case = list_cases(suite)[0]

    def first(seed: int) -> np.ndarray:
        return next(film_case(case, suite.model_copy(update={"seed": seed}), cache)[0].images.frames())

    assert np.array_equal(first(1), first(1))
    assert not np.array_equal(first(1), first(2))
