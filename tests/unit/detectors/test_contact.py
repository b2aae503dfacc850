import numpy as np
import pytest

from magicsim.detectors import Contact, DetectorProfile
from magicsim.detectors.features import decide_contact, grid_areas, grid_similarity
from magicsim.detectors.fusion import fuse_grid

MEASURES = ("recall", "iou", "dice")


def image(*rows: str) -> np.ndarray:
    """`#` is dark (10), `.` is bright (90), alike in all channels."""
    grey = np.array([[10 if mark == "#" else 90 for mark in row] for row in rows], dtype=np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def similarity(references, frame, measure="recall", polarity="dark"):
    grid = fuse_grid(references, DetectorProfile(polarity=polarity, grid_blur_px=0))
    return grid_similarity(grid_areas(frame, grid), measure)


@pytest.mark.parametrize(("measure", "expected"), [("recall", 2 / 4), ("iou", 2 / 5), ("dice", 4 / 7)])
def test_dark_grid_by_hand(measure, expected):
    # reference 4 dark, frame 3 dark, 2 in common
    assert similarity([image("####..")], image("..##.#"), measure) == pytest.approx(expected)


@pytest.mark.parametrize(("measure", "expected"), [("recall", 1 / 2), ("iou", 1 / 4), ("dice", 2 / 5)])
def test_bright_grid_by_hand(measure, expected):
    # reference 2 bright, frame 3 bright, 1 in common
    assert similarity([image("####..")], image("..####"), measure, "bright") == 0.0
    assert similarity([image("####..")], image("..##.#"), measure, "bright") == pytest.approx(expected)


@pytest.mark.parametrize(("measure", "expected"), [("recall", 1.5 / 2), ("iou", 1.5 / 2.5), ("dice", 3 / 4)])
def test_soft_reference_counts_by_its_share(measure, expected):
    # presence 1, 0.5, 0.5, 0; the frame shows the first two: i = 1.5, f = 2, r = 2
    references = [image("##.."), image("#.#.")]
    assert similarity(references, image("##.."), measure) == pytest.approx(expected)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("polarity", ["dark", "bright"])
def test_unchanged_frame_scores_one(measure, polarity):
    frame = image("##..", "#.#.")
    assert similarity([frame] * 3, frame, measure, polarity) == 1.0


@pytest.mark.parametrize("measure", MEASURES)
def test_soft_reference_matches_fuzzy_sets_on_random_frames(measure):
    rng = np.random.default_rng(3)
    references = [rng.integers(0, 80, (6, 7, 3), dtype=np.uint8) for _ in range(4)]
    frame = rng.integers(0, 80, (6, 7, 3), dtype=np.uint8)
    values = []
    for channel in range(3):
        soft = np.mean([reference[..., channel] <= 35 for reference in references], axis=0)
        hard = (frame[..., channel] <= 35).astype(float)
        shared, either = np.minimum(hard, soft).sum(), np.maximum(hard, soft).sum()
        values.append(
            {
                "recall": shared / soft.sum(),
                "iou": shared / either,
                "dice": 2 * shared / (hard.sum() + soft.sum()),
            }[measure]
        )
    assert similarity(references, frame, measure) == pytest.approx(np.mean(values), abs=1e-12)


def test_brightening_lowers_the_dark_grid_but_not_the_recall_of_the_bright_one():
    rest, lit = image("##.."), np.full((1, 4, 3), 200, dtype=np.uint8)
    assert similarity([rest], lit, polarity="dark") == 0.0
    assert similarity([rest], lit, polarity="bright") == 1.0
    assert similarity([rest], lit, "iou", polarity="bright") == 0.5


def test_channel_without_grid_is_left_out_of_the_mean():
    rest = image("##..")
    rest[..., 0] = 200
    frame = image("#...")
    assert similarity([rest], frame) == pytest.approx(0.5)


def test_channels_weigh_equally():
    rest = image("##..")
    frame = rest.copy()
    frame[..., 1] = 90
    assert similarity([rest], frame) == pytest.approx(2 / 3)


@pytest.mark.parametrize(("value", "expected"), [(0.599, Contact.TOUCHED), (0.6, Contact.UNTOUCHED)])
def test_similarity_at_the_threshold_is_untouched(value, expected):
    assert decide_contact(value, DetectorProfile()) is expected
