"""What must not tell a touch, a flashlight or a far object, in small frames, by what the benchmark asks."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import numpy.typing as npt
import pytest
from contact_tell import BLOCK_PX, Shown, Taken, film, judge
from threadpoolctl import threadpool_limits

from magicsim.light.backend import VARIANT

Frame = npt.NDArray[np.uint8]
SMALL = (
    "design.lattice.spacing_mm=1.5", "rig.camera.columns=60", "rig.camera.rows=80", "render.samples=2",
    "render.particles=4000", "render.anchor_samples=8", "render.anchor_particles=60000", "render.facet_mm=1",
)  # fmt: skip
CASES, SMALL_BLOCK_PX = 3, 5
CHANCE = 3.0
"""Standard deviations of Mann and Whitney's statistic above one half from which on an area counts as told. A classifier
that is wrong on cases that it has not seen, whose area is below one half, has been told nothing."""
NOISE = ("residual noise", "noise levels of blocks")


@pytest.fixture(autouse=True)
def _one_thread() -> Iterator[None]:
    with threadpool_limits(1):  # threads of small fits cost more than they save
        yield


def areas(frames: list[Taken], kinds: Sequence[str] = ()) -> list[float]:
    """Areas under the curve, of some kinds of features or of all."""
    shown = [Shown.of(each) for each in frames]
    return [judge(shown, kind, np.random.default_rng(1))["auc"] for kind in kinds or shown[0].features]


def told_from(frames: list[Taken]) -> float:
    """Area from which on something is told: where nothing is, its deviation is sqrt((m + n + 1) / (12 m n))."""
    told = sum(each.label for each in frames)
    other = len(frames) - told
    return 0.5 + CHANCE * float(np.sqrt((told + other + 1) / (12 * told * other)))


def with_noise(frames: list[Taken], level: Callable[[bool], float]) -> list[Taken]:
    """Frames with noise of a standard deviation that may depend on their label [grey levels]."""
    random = np.random.default_rng(3)
    return [
        Taken(
            case=each.case, label=each.label, rest=each.rest, far=each.far,
            frame=_rounded(each.frame + random.normal(0, level(each.label), each.frame.shape)),
        )
        for each in frames
    ]  # fmt: skip


def _rounded(values: npt.NDArray[np.float64]) -> Frame:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def plain_frames() -> list[Taken]:
    """Six sensors that look each a little otherwise, ten frames each, all of them as at rest."""
    random = np.random.default_rng(5)
    blocks = [
        (slice(top, top + BLOCK_PX), slice(left, left + BLOCK_PX))
        for top in range(0, 120, BLOCK_PX)
        for left in range(0, 80, BLOCK_PX)
    ]
    looks = [_rounded(random.uniform(60, 120, (120, 80, 3))) for _ in range(6)]
    return [
        Taken(case=case, label=bool(number % 2), frame=look, rest=look, far=blocks)
        for case, look in enumerate(looks)
        for number in range(10)
    ]


def test_as_much_noise_in_both_classes_is_not_told():
    frames = with_noise(plain_frames(), lambda _: 1.0)
    assert max(areas(frames, NOISE)) < told_from(frames)


def test_four_per_cent_more_noise_in_one_class_is_told():
    frames = with_noise(plain_frames(), lambda label: 1.04 if label else 1.0)
    assert min(areas(frames, NOISE)) > told_from(frames)


@pytest.fixture(scope="module")
def filmed() -> dict[str, list[Taken]]:
    """Frames of some cases, by question."""
    if VARIANT == "scalar_rgb":
        pytest.skip("needs LLVM or CUDA")
    found: dict[str, list[Taken]] = {}
    for case in range(CASES):
        for question, taken in film(case, 1, SMALL, SMALL_BLOCK_PX):
            found.setdefault(question, []).append(taken)
    return found


@pytest.mark.slow
def test_no_question_is_answered_by_what_must_not_know(filmed):
    *told_apart, far = filmed.values()
    assert len(told_apart) == 3
    for frames in told_apart:
        assert max(areas(frames)) < told_from(frames)
    for case in range(CASES):  # an object that is too far to be seen is left out
        looks = {each.frame.tobytes() for each in far if each.case == case}
        assert len(looks) == 1


@pytest.mark.slow
def test_frames_under_a_flashlight_share_as_much_of_their_noise_across_contact_as_others(filmed):
    def changes(question: str) -> npt.NDArray[np.float64]:
        """Grey levels by which places far from the contact change from before it to after it, by case and gap."""
        frames = filmed[question]
        pairs = zip(frames[::2], frames[1::2], strict=True)
        return np.array([
            np.mean([np.abs(near.frame[block].astype(float) - touched.frame[block]).mean() for block in near.far])
            for near, touched in pairs
        ])  # fmt: skip

    assert changes("before or after contact, flashlight on").mean() < 2 * changes("before or after contact").mean()


@pytest.mark.slow
def test_a_tenth_more_noise_in_touched_frames_would_be_told(filmed):
    frames = with_noise(filmed["before or after contact"], lambda label: 1.1 if label else 1.0)
    assert min(areas(frames, NOISE)) > told_from(frames)
