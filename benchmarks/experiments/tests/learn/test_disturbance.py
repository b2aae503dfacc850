"""Random errors of what networks learn from."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("torch")

import torch

from magicsim_experiments.learn.disturbance import Disturbance

from .made import made_samples

SD = 0.1


def disturbance(samples, share=0.5):
    return Disturbance.of(samples, SimpleNamespace(input_sd=(SD,) * 6), share)


def test_errors_are_a_share_of_the_change_around_and_leave_the_reference_alone():
    samples = made_samples(200, 1, rows=32, columns=32)
    images = torch.zeros((200, 6, 32, 32))
    torch.manual_seed(0)
    found = disturbance(samples).added(images, np.arange(200)).numpy() * SD
    assert not found[:, 3:].any()
    square = torch.from_numpy(np.square(samples.inputs("difference")).mean(-1))[:, None]
    nearby = float(torch.nn.functional.avg_pool2d(square, 9, 1)[..., 4:-4, 4:-4].mean())
    assert np.sqrt(np.square(found[:, :3, 8:-8, 8:-8]).mean() / nearby) == pytest.approx(0.5, rel=0.05)
    still = np.zeros_like(samples.images) + samples.references
    nothing = disturbance(replace(samples, images=still)).added(images, np.arange(200))
    assert not nothing.any()


def test_errors_of_neighbours_are_alike_and_those_of_frames_are_not():
    samples = made_samples(60, 1, rows=40, columns=40)
    sizes = disturbance(samples, 1.0)
    sizes.sizes.fill_(1.0)
    torch.manual_seed(1)
    found = sizes.added(torch.zeros((60, 3, 40, 40)), np.arange(60))[:, :, 8:-8, 8:-8].numpy() * SD
    own = (found**2).mean()
    assert own == pytest.approx(1.0, rel=0.05)
    beside = (found[..., 1:] * found[..., :-1]).mean() / own
    assert beside == pytest.approx(0.56**2 * 6 / 7 + 0.3**2, abs=0.05)
    assert abs((found[1:] * found[:-1]).mean()) < 0.05
