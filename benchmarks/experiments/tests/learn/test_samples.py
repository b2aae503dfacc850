import numpy as np
from dataset.fakes import FAKE, small_recipe

from magicsim.dataset.generate import generate_dataset
from magicsim.workers.attempt import choose_workers
from magicsim_experiments.learn.samples import Chosen, EpisodeRows, Label, object_key, read_samples, reduced

LABELS = (Label(name="depth", unit="mm"),)


def not_first(episode: EpisodeRows) -> Chosen:
    count = len(episode.images)
    depth = np.array(episode.columns["depth_mm"])[:, None]
    return Chosen(rows=np.arange(count) > 1, targets=depth, features=depth, group=np.zeros(count, int))


def test_rows_of_a_dataset_become_samples_in_the_order_of_episodes(tmp_path):
    generate_dataset(small_recipe(), tmp_path / "data", options=choose_workers(1), simulator=FAKE)
    found = read_samples(tmp_path / "data", LABELS, not_first, columns=("depth_mm",), long_side_px=16)
    assert found.images.shape[1:] == (16, 12, 3)
    assert list(found.press) == sorted(found.press)
    assert set(found.press) == set(range(5))
    np.testing.assert_array_equal(found.unit, found.press // 3)
    assert len(found.references) == 5
    np.testing.assert_array_equal(found.reference_of, found.press)
    assert (found.targets[:, 0] == found.features[:, 0]).all()
    part = found.at(np.flatnonzero(found.press == 2))
    assert set(part.press) == {2}


def test_reduced_frame_keeps_the_mean():
    image = np.random.default_rng(0).integers(0, 255, (64, 48, 3), np.uint8)
    found = reduced(image, 16)
    assert found.shape == (16, 12, 3)
    assert abs(found.mean() - image.mean()) < 0.01
    assert reduced(image, 0).shape == reduced(image, 100).shape == image.shape


def test_object_is_the_same_however_it_is_turned():
    configs = [
        '{"kind": "cylinder", "radius_mm": 5.0, "yaw_deg": 10.0}',
        '{"yaw_deg": -3, "radius_mm": 5.0, "kind": "cylinder"}',
    ]
    assert (
        object_key(["", configs[0]])
        == object_key([configs[1]])
        != object_key(['{"kind": "cylinder", "radius_mm": 7.5}'])
    )
    assert (object_key(["", ""]), object_key(["", "key"])) == ("", "key")
