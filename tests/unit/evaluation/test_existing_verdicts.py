"""Verdicts on labelled frames are those on the same images beside their references."""

import io
import json

import cv2
import numpy as np

from magicsim.detectors import detect_all, fuse, load_profile
from magicsim.detectors.offline import write_verdicts
from magicsim.evaluation.existing import write_existing_verdicts
from magicsim.judge.recorded import read_recording
from magicsim.judge.verdicts import SensorDetector


def test_units_of_rest_follow_drift_in_a_recording_as_in_a_folder_of_images(tmp_path):
    random, (y, x) = np.random.default_rng(0), np.mgrid[:40, :32]
    grid = np.stack([100 - 30 * ((x % 6 < 2) | (y % 6 < 2)) + slope * x for slope in (0.2, 0.4, -0.3)], -1)
    spot = np.exp(-((x - 16) ** 2 + (y - 20) ** 2) / 60)[..., None] * [6, 4, 2]
    lines = ["file,is_reference,gap_mm,force_n,flashlight"]
    for folder, count, grown in (("ref", 30, 0.0), ("seen", 60, 1.0)):
        (tmp_path / folder).mkdir()
        for number in range(count):
            image = grid + grown * spot * number / count + random.normal(0, 0.8, grid.shape)
            name = f"{folder}/{number:03}.png"
            cv2.imwrite(str(tmp_path / name), np.clip(image, 0, 255).astype(np.uint8))
            lines.append(f"{name},{int(folder == 'ref')},,0,0")
    (tmp_path / "truth.csv").write_text("\n".join(lines) + "\n")
    episode, profile = read_recording(tmp_path).episode(), load_profile("rest-relative")
    detector = SensorDetector.of(episode.references, profile)
    followed = list(detector.verdicts(episode.frames))
    assert followed == detect_all(episode.frames, fuse(episode.references, profile), profile)
    assert followed[-1] != detector.verdict(episode.frames[-1])
    recording, images = io.StringIO(), io.StringIO()
    write_existing_verdicts(recording, tmp_path, "rest-relative", as_json=True)
    write_verdicts(images, tmp_path / "seen", tmp_path / "ref", "rest-relative", as_json=True)
    first, second = (json.loads(each.getvalue())["frames"] for each in (recording, images))
    assert len(first) == len(second) == 60
    for name in ("entropy", "similarity", "combined", "proximity"):
        assert [each[name] for each in first] == [each[name] for each in second]
