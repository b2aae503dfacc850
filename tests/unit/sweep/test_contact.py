from types import SimpleNamespace

import numpy as np

from magicsim.detectors.verdict import Contact
from magicsim.sweep.detection import ContactScores, contact_accuracy, contact_auc, contact_scores
from magicsim.sweep.film import REFERENCES, SPAN


def scores(touched: np.ndarray, *, alarm_under_light: bool = False) -> ContactScores:
    near, clear = np.full((6, 4), 0.95), np.full(24, 0.97)
    return ContactScores(
        touched=touched, near=near, clear=clear, hit=touched < 0.9, near_alarm=near < 0.9, clear_alarm=clear < 0.9,
        light_alarm=np.full((2, 4), alarm_under_light),
    )  # fmt: skip


def test_touches_that_all_lower_the_similarity_are_told_apart():
    found = scores(np.full((6, 4), 0.8))
    assert contact_auc([found], seed=1).value == 1
    assert contact_accuracy([found], seed=1).value == 1


def test_place_that_is_missed_widens_the_interval():
    touched = np.full((6, 4), 0.8)
    touched[2] = 0.99
    area, accuracy = contact_auc([scores(touched)], seed=1), contact_accuracy([scores(touched)], seed=1)
    assert abs(area.value - 5 / 6) < 1e-9
    assert abs(accuracy.value - (5 / 6 + 1) / 2) < 1e-9
    assert area.low < area.value < area.high <= 1


def test_outside_light_that_is_taken_for_a_touch_costs_a_third_of_the_alarms():
    found = contact_accuracy([scores(np.full((6, 4), 0.8), alarm_under_light=True)], seed=1)
    assert abs(found.value - (1 + 2 / 3) / 2) < 1e-9


def test_rendering_in_which_touches_are_missed_counts_as_much_as_the_others():
    seen, missed = scores(np.full((6, 4), 0.8)), scores(np.full((6, 4), 0.99))
    found = contact_auc([seen, seen, missed], seed=1)
    assert abs(found.value - 2 / 3) < 1e-9
    assert found.low < 0.4
    assert found.high == 1


def test_frames_of_the_test_never_reach_the_noise_of_the_references():
    used = []

    def frames(shown, draws, *, first, drift):
        del shown, drift
        used.append((first, first + draws))
        return [None] * draws

    verdict = SimpleNamespace(similarity=0.9, combined=Contact.UNTOUCHED)
    film = SimpleNamespace(light_touches=range(60), near=range(60), light=range(4), untouched=0, frames=frames)
    detector = SimpleNamespace(verdicts=lambda shown: [verdict] * len(shown))
    found = contact_scores(film, detector, 200, drift=0.02)
    assert found.touched.shape == (30, 200)
    assert max(last for _, last in used) <= SPAN - REFERENCES
    assert len(found.clear) > 800
    assert contact_scores(film, detector, 3, drift=0.02, touches=range(8)).touched.shape == (4, 3)
