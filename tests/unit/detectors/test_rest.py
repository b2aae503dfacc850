"""Thresholds in units of the untouched sensor: what leaves them alone, what a touch does, and what is refused."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from magicsim.detectors import Contact, Proximity, detect, detect_all, fuse, load_profile, with_touches
from magicsim.detectors.calibrate import fit_profile
from magicsim.detectors.combined import followed
from magicsim.detectors.offline import detect_sources
from magicsim.detectors.profile import DetectorProfile
from magicsim.errors import ConfigError, FrameError

PROFILE = load_profile("rest-relative")
ROWS, COLUMNS = 60, 80


def scene(random, *, white=True):
    """An untouched picture: smooth, bright at the sides, with dark dots [grey levels]."""
    x = np.linspace(-1, 1, COLUMNS)[None, :, None] * np.ones((ROWS, 1, 3))
    light = x**2 if white else np.clip(x * np.array([1.0, -1.0, 0.0]) + np.array([0, 0, 0.5]), 0, 1)
    rows, columns = np.indices((ROWS, COLUMNS))
    dots = ((rows % 10 < 3) & (columns % 10 < 3))[..., None]
    return (40 + 60 * light) * np.where(dots, 0.5, 1.0) + random.normal(0, 0.5, (ROWS, COLUMNS, 3))


def shot(picture, random, *, noise=1.0, gain=1.0):
    return np.clip(np.rint(gain * picture + random.normal(0, noise, picture.shape)), 0, 255).astype(np.uint8)


def touched(picture, share=0.6):
    """A bright spot of 12 px."""
    rows, columns = np.indices(picture.shape[:2])
    spot = np.exp(-((rows - 30) ** 2 + (columns - 40) ** 2) / 2 / 6**2)
    return picture * (1 + share * 2 * spot[..., None])


@pytest.fixture
def rest():
    random = np.random.default_rng(3)
    picture = scene(random)
    return picture, fuse([shot(picture, random) for _ in range(12)], PROFILE), random


@pytest.mark.parametrize("gain", [0.7, 1.0, 1.35])
@pytest.mark.parametrize("noise", [0.5, 1.0])
def test_no_exposure_and_no_quieter_noise_is_a_touch(rest, gain, noise):
    picture, references, random = rest
    verdict = detect(shot(picture, random, gain=gain, noise=noise), references, PROFILE)
    assert verdict.combined is Contact.UNTOUCHED
    assert verdict.similarity > 0.997
    assert verdict.proximity is Proximity.NORMAL


@pytest.mark.parametrize("gain", [0.7, 1.0, 1.35])
def test_a_touch_is_told_at_every_exposure(rest, gain):
    picture, references, random = rest
    verdict = detect(shot(touched(picture), random, gain=gain), references, PROFILE)
    assert verdict.combined is Contact.TOUCHED


def test_larger_frames_are_judged_as_small_ones(rest):
    picture, references, random = rest
    large = cv2.resize(touched(picture), (4 * COLUMNS, 4 * ROWS), interpolation=cv2.INTER_LINEAR)
    plain = cv2.resize(picture, (4 * COLUMNS, 4 * ROWS), interpolation=cv2.INTER_LINEAR)
    found = fuse([shot(plain, random) for _ in range(12)], PROFILE)
    assert found.rest.shape == (4 * ROWS, 4 * COLUMNS, 3)
    assert found.rest.mean.shape == (120, 160, 3)
    large_s = detect(shot(large, random), found, PROFILE).similarity
    assert large_s == pytest.approx(detect(shot(touched(picture), random), references, PROFILE).similarity, abs=0.01)


def test_c_tells_light_from_a_touch_only_where_the_sensors_own_light_is_coloured():
    random = np.random.default_rng(4)
    for white in (True, False):
        picture = scene(random, white=white)
        references = fuse([shot(picture, random) for _ in range(12)], PROFILE)
        lit = detect(shot(picture + touched(np.full_like(picture, 40.0)) - 40, random), references, PROFILE)
        assert (lit.proximity is Proximity.NOISE) is not white
        assert references.rest.likeness > 0.9 if white else references.rest.likeness < 0.3


def test_levels_follow_slowly_and_only_while_untouched(rest):
    picture, references, random = rest
    calm = detect(shot(picture, random), references, PROFILE)
    lower = replace(calm, similarity=0.995, entropy=0.2)
    moved = followed(references, lower, PROFILE).rest
    assert 0 < references.rest.similarity - moved.similarity < 0.005 / 200
    assert 0 < moved.entropy - references.rest.entropy < 0.2 / 100
    for changed in ({"contact": Contact.TOUCHED}, {"proximity": Proximity.NOISE}):
        assert followed(references, replace(lower, **changed), PROFILE) == references
    near = followed(references, replace(lower, proximity=Proximity.APPROACHING), PROFILE).rest
    assert references.rest.similarity - near.similarity < (references.rest.similarity - moved.similarity) / 5
    fixed = fuse([shot(picture, random)] * 3, load_profile("published"))
    assert followed(fixed, calm, load_profile("published")) is fixed


def test_slow_drift_is_nothing_near(rest):
    picture, references, random = rest
    drifting = [shot(touched(picture, 0.18 * number / 1500), random) for number in range(1500)]
    first = detect(drifting[-1], references, PROFILE)
    assert first.proximity is Proximity.APPROACHING
    assert {each.proximity for each in detect_all(drifting, references, PROFILE)} == {Proximity.NORMAL}


def test_own_touches_set_the_threshold(rest):
    picture, references, random = rest
    firm, light = shot(touched(picture, 2.5), random), shot(touched(picture), random)
    assert detect(light, references, PROFILE).combined is Contact.TOUCHED
    known = with_touches(references, [firm, firm], PROFILE)
    assert detect(light, known, PROFILE).combined is Contact.UNTOUCHED
    assert detect(firm, known, PROFILE).combined is Contact.TOUCHED


def test_refusals_name_what_is_wrong(rest, tmp_path):
    picture, references, random = rest
    frames = [shot(picture, random) for _ in range(4)]
    with pytest.raises(ConfigError, match="touches do not lower S"):
        with_touches(references, frames, PROFILE)
    with pytest.raises(ConfigError, match=r"must be below 0\.99\d+ in frames of firm touches alone"):
        with_touches(references, frames, PROFILE)
    with pytest.raises(ConfigError, match="touches hold no frame"):
        with_touches(references, [], PROFILE)
    published = load_profile("published")
    with pytest.raises(ConfigError, match="touches are not allowed with fixed thresholds"):
        with_touches(fuse(frames, published), frames, published)
    with pytest.raises(ConfigError, match=r"units = 'rest', but the references were fused with 'fixed'"):
        detect(frames[0], fuse(frames, published), PROFILE)
    with pytest.raises(FrameError, match="at least 3"):
        fuse(frames[:2], replace(PROFILE, background_count=1))
    with pytest.raises(FrameError, match=r"must be \(60, 80, 3\)"):
        detect(frames[0][:-1], references, PROFILE)
    with pytest.raises(ConfigError, match=r"tau_b = 120 .* per cent of the pixels"):
        DetectorProfile(units="rest", tau_b=120)
    with pytest.raises(ConfigError, match="not allowed in the base of a fit"):
        fit_profile(PROFILE, [])
    for name, images in (("rest", frames), ("touch", [shot(touched(picture), random)])):
        (tmp_path / name).mkdir()
        for number, image in enumerate(images):
            cv2.imwrite(str(tmp_path / name / f"{number}.png"), image)
    found = detect_sources(tmp_path / "touch", tmp_path / "rest", "rest-relative", touches=tmp_path / "touch")
    assert found[0].combined is Contact.TOUCHED
