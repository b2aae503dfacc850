"""Of training itself; PyTorch is optional."""

import json
from dataclasses import replace

import numpy as np
import pytest

from magicsim.errors import ConfigError, FrameError

pytest.importorskip("torch")
pytest.importorskip("safetensors")

from magicsim_experiments.learn.fitting import Fit, split_of
from magicsim_experiments.learn.model_file import model_config, read_model
from magicsim_experiments.learn.networks import open_network
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.learn.training import answers_with, train

from .made import made_samples

SETTINGS = LearningSettings(epochs=14, patience=14, batch=8, long_side_px=0)


def trained(settings=SETTINGS, network="small", presses=24, **options):
    samples = made_samples(presses)
    split = split_of(samples, Fit(name="press-0", network=network, fold=0, folds=4), settings, seed=3)
    config = model_config(samples, split.train, settings, network=network, frame_size=(20, 16), study="test")
    return samples, split, config, train(samples, split, settings, config, seed=3, **options)


def test_network_learns_a_number_a_flag_and_a_choice():
    settings = SETTINGS.model_copy(update={"epochs": 20, "batch": 16})
    samples, split, config, done = trained(settings, presses=80)
    truth = samples.targets[split.test]
    there = np.isfinite(truth[:, 0])
    assert np.abs(done.answers[there, 0] - truth[there, 0]).mean() < 0.12  # a constant: 0.4
    assert ((done.answers[:, 1] > 0.5) == (truth[:, 1] > 0.5)).mean() > 0.9
    assert (done.answers[there, 2] == truth[there, 2]).mean() > 0.6
    assert done.log[-1]["train_loss"] < 0.5 * done.log[0]["train_loss"]
    np.testing.assert_allclose(
        answers_with(open_network(done.model, config), samples.at(split.test), config), done.answers, atol=1e-4
    )


def test_training_in_stretches_gives_the_same_bytes_on_a_cpu():
    settings = SETTINGS.model_copy(update={"device": "cpu"})
    whole = trained(settings)[3]
    checkpoint, stretches = None, 0
    while True:
        part = trained(settings, checkpoint=checkpoint, seconds=0.0)[3]
        stretches += 1
        checkpoint = part.checkpoint
        if checkpoint is None:
            break
    assert stretches == SETTINGS.epochs
    assert part.model == whole.model
    assert part.log == whole.log
    np.testing.assert_array_equal(part.answers, whole.answers)


def test_training_stops_when_validation_gets_no_better():
    settings = SETTINGS.model_copy(update={"epochs": 40, "patience": 2, "learning_rate": 0.05})
    log = trained(settings)[3].log
    assert len(log) < 40
    best = min(row["validation_loss"] for row in log)
    assert all(row["validation_loss"] >= best for row in log[-2:])


def test_resnet18_takes_the_same_frames():
    settings = SETTINGS.model_copy(update={"epochs": 1})
    _, _, config, done = trained(settings, network="resnet18")
    assert config.network == "resnet18"
    assert np.isfinite(done.answers).all()


def test_a_model_of_both_reads_the_untouched_frame_too():
    samples, split, config, done = trained(SETTINGS.model_copy(update={"input": "both"}))
    assert len(config.input_mean) == 6
    shown = samples.at(split.test)
    lit = replace(shown, images=shown.images + 9, references=shown.references + 9)  # the difference stays
    network = open_network(done.model, config)
    assert np.abs(answers_with(network, lit, config) - answers_with(network, shown, config)).max() > 1e-3


def test_model_file_says_what_it_reads_and_refuses_what_is_none(tmp_path):
    _, _, config, done = trained(SETTINGS.model_copy(update={"epochs": 1}))
    path = tmp_path / "model.safetensors"
    path.write_bytes(done.model)
    assert read_model(path)[0] == config
    path.write_bytes(b"\x10" + b"\0" * 7 + json.dumps({}).encode() + b" " * 14)
    for name in (path, tmp_path / "none"):
        with pytest.raises(ConfigError, match=r"does not exist|is not a model of magicsim"):
            read_model(name)


def test_estimate_reads_frames_beside_a_reference_and_refuses_another_size(tmp_path):
    import cv2

    from magicsim_experiments.learn.reading import estimate_frames

    samples, split, _, done = trained()
    model = tmp_path / "model.safetensors"
    model.write_bytes(done.model)
    (tmp_path / "frames").mkdir()
    chosen = split.test[:3]
    for place, row in enumerate(chosen):
        cv2.imwrite(str(tmp_path / f"frames/{place}.png"), np.rint(samples.images[row])[:, :, ::-1])
    cv2.imwrite(str(tmp_path / "untouched.png"), np.rint(samples.references[0])[:, :, ::-1])
    found = list(estimate_frames(model, tmp_path / "frames", reference=tmp_path / "untouched.png"))
    assert [each.frame for each in found] == ["0.png", "1.png", "2.png"]
    np.testing.assert_allclose([each.values["x"] for each in found], done.answers[:3, 0], atol=0.1)
    assert len(list(estimate_frames(model, tmp_path / "frames", reference=tmp_path / "untouched.png", frames=1))) == 1
    with pytest.raises(ConfigError, match="--reference is missing"):
        list(estimate_frames(model, tmp_path / "frames"))
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((10, 16, 3), np.uint8))
    with pytest.raises(FrameError, match="16 x 10 pixels; the model takes frames of 16 x 20"):
        list(estimate_frames(model, tmp_path / "small.png", reference=tmp_path / "untouched.png"))
