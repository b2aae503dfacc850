"""What the published detectors read of the filmed states through one camera, and how the colours behave."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
import numpy.typing as npt

from laboratory.operating_point.filming import GAPS_MM, FilmedStates
from magicsim.camera.camera import Camera
from magicsim.camera.disturbances import transmittance
from magicsim.camera.exposure import aimed_signal, meter, sensed
from magicsim.camera.film import spread_light
from magicsim.camera.stream import CameraMemory, CameraStream, Instant, corrected, metered
from magicsim.detectors import Contact, DetectorProfile, Proximity, References, Verdict, detect, fuse
from magicsim.fit.strengths import block_means

Array = npt.NDArray[np.float64]
FloatImage = npt.NDArray[np.float32]
Frame = npt.NDArray[np.uint8]
NEAR_MM = 3.0
"""Up to this gap an object counts as near."""
BLOCKS = (8, 6)
"""Blocks down and across in which the evenness of a colour is told."""
SETTLING = 24
"""Frames after which a live camera counts as settled: its quickest one comes to 1e-7 of the error."""
RATE = 15.0
"""Frames a second, as of a scene."""
MARGIN = 0.3
"""Distance from a threshold that counts as none, in units of `SCALES`."""
SCALES = {"similarity": 0.1, "entropy": 0.5, "correlation": 0.2}
"""What counts as one, entropy in bit; our own choice."""
SEED = 7
"""Of the camera's noise: the same for all cameras, so that they differ by their constants alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Quantities of one sensor, by the names of `laboratory.operating_point.targets.TARGETS`, and its colours."""

    quantities: dict[str, float]
    correlation: list[float]
    """C at each of `GAPS_MM` and `TOUCHES_MM`."""
    entropy: list[float]
    """E at each of them [bit]."""
    similarity: list[float]
    """S at each of them."""
    evenness: list[float]
    """Of red, green and blue at rest: darkest over brightest block."""
    disparity: dict[str, float]
    """At `rest`, in `touch` and under `light`: how differently the channels are spread over the face, see `disparity`;
    of what brightens for the last two."""
    right: dict[str, float]
    """Shares of right verdicts: `untouched` and `touched` of contact, `near` (`NEAR_MM`) and `light` of proximity."""


def read_states(
    states: FilmedStates, camera: Camera, *, ambient: float, flashlight: float, crosstalk: float,
    profile: DetectorProfile,
) -> Reading:  # fmt: skip
    """All quantities.

    Args:
        states: Radiances.
        camera: Exposure, tone curve, noise and effects; its colour matrix is replaced. Where its exposure is live, each
            state is looked at for long. Frames follow each other at `RATE`, so that lights flicker and drift.
        ambient: Mean radiance of the room, in the units of the strips' radiance.
        flashlight: Strength of the flashlight in units of the rendered one.
        crosstalk: Share of each pixel's signal that comes from the two other colours, half each.
        profile: Options of the detectors.

    Raises:
        RenderError: Exposure fails.
        FrameError: The references show no grid.
    """
    mixed = camera.model_copy(update={"color_matrix": crosstalk_matrix(crosstalk)})
    seen_states = states.strips.plus(states.room, ambient)
    count = profile.reference_count

    dust = None
    if mixed.dust is not None:
        dust = transmittance(mixed.dust, rows=mixed.rows, columns=mixed.columns, pattern_seed=mixed.pattern_seed)

    def on_film(radiance: FloatImage) -> FloatImage:
        spread = spread_light(radiance, None, mixed.glare)
        return spread if dust is None else np.asarray(spread * dust[..., None], np.float32)

    first = meter(on_film(seen_states.rest), mixed)
    stream = CameraStream(camera=mixed, gain=first, room=on_film(np.float32(ambient) * states.room.rest))

    def settled(radiance: FloatImage) -> tuple[FloatImage, CameraMemory]:
        seen = on_film(radiance)
        gain = first if mixed.live is None else settled_gain(seen, mixed, first)
        return seen, CameraMemory(gains=(gain,))

    def shoot(state: tuple[FloatImage, CameraMemory], frame: int) -> Frame:
        at = Instant(seed=SEED, index=frame, time_s=frame / RATE, frames_per_second=RATE)
        return stream.take(*state, at)[0]

    at_rest = settled(seen_states.rest)
    resting = [shoot(at_rest, number) for number in range(count)]
    references: References = fuse(resting, profile)
    lit = (seen_states.rest + flashlight * states.light).astype(np.float32)
    later = [at_rest, *(settled(image) for image in (*seen_states.near, *seen_states.touch, lit))]
    shots = [shoot(state, count + number) for number, state in enumerate(later)]
    rest, *others, light = [detect(shot, references, profile) for shot in shots]
    near, touch = others[: len(GAPS_MM)], others[len(GAPS_MM) :]
    seen = [each.proximity is Proximity.APPROACHING for each in near]
    noticed = [place for place, each in enumerate(near) if each.entropy >= profile.tau_e]
    close = [each for each, gap in zip(near, GAPS_MM, strict=True) if gap <= NEAR_MM]
    s_near, c_near = (float(np.mean([getattr(each, name) for each in close])) for name in ("similarity", "correlation"))
    way = [each.correlation for each in near[noticed[0] if noticed else 0 :]]
    return Reading(
        quantities={
            "s_rest": rest.similarity,
            "s_near": s_near,
            "s_touch": touch[0].similarity,
            "s_sway": max(abs(each.similarity - s_near) for each in near),
            "s_drop": s_near - touch[0].similarity,
            "s_light": light.similarity,
            "c_far": way[0],
            "c_near": c_near,
            "c_back": max((later - sooner for sooner, later in pairwise(way)), default=0.0),
            "c_rise": touch[-1].correlation - near[-1].correlation,
            "c_light": light.correlation,
            "e_rest": rest.entropy,
            "e_near": max(each.entropy for each in close),
            "lead_mm": lead_mm(seen),
        },
        correlation=[each.correlation for each in others],
        entropy=[each.entropy for each in others],
        similarity=[each.similarity for each in others],
        evenness=evenness(np.mean(resting, axis=0)),
        disparity={
            "rest": disparity(np.mean(resting, axis=0)),
            "touch": disparity(_brightening(shots[len(GAPS_MM) + 1], resting)),
            "light": disparity(_brightening(shots[-1], resting)),
        },
        right=_right([rest, *near, light], touch, close, light),
    )


def settled_gain(radiance: FloatImage, camera: Camera, first: Array) -> Array:
    """Gains of a live camera that has looked at one state for long, shape (3,)."""
    assert camera.live is not None
    quick = camera.live.model_copy(
        update={"tolerance": 0.0, "delay_frames": 0, "time_constant_frames": 1.0, "white_balance_frames": 1.5}
    )
    seen, gain, aim = sensed(radiance, camera), first, aimed_signal(camera)
    for _ in range(SETTLING):
        gain = corrected(gain, metered(seen, gain, quick.metering), quick, aim=aim, first=first)
    return gain


def lead_mm(seen: Sequence[bool]) -> float:
    """Largest of `GAPS_MM` from which on the object is called Approaching until contact [mm]; 0 where never."""
    lead = 0.0
    for gap, approaching in zip(reversed(GAPS_MM), reversed(seen), strict=True):
        if not approaching:
            return lead
        lead = gap
    return lead


def crosstalk_matrix(share: float) -> tuple[tuple[float, float, float], ...]:
    """Colour matrix whose pixels take a share of their signal from the two other colours."""
    return tuple(
        tuple(1 - share if row == column else share / 2 for column in range(3))  # type: ignore[misc]
        for row in range(3)
    )


def evenness(image: Array) -> list[float]:
    """Darkest over brightest block of each channel, 1 where a colour is even over the face."""
    blocks = block_means(image, BLOCKS)
    return [
        float(low / high) if high > 0 else 1.0 for low, high in zip(blocks.min((0, 1)), blocks.max((0, 1)), strict=True)
    ]


def disparity(image: Array) -> float:
    """How differently three channels are spread over the face; 0 where all have one shape.

    Root mean square difference of their block means, each in units of its own mean, averaged over the three pairs.
    """
    blocks = block_means(image, BLOCKS)
    means = blocks.mean((0, 1))
    if not (means > 0).all():
        return 0.0
    shapes = blocks / means
    pairs = [np.sqrt(np.mean((shapes[..., a] - shapes[..., b]) ** 2)) for a, b in combinations(range(3), 2)]
    return float(np.mean(pairs))


def short_of(reading: Reading, profile: DetectorProfile) -> float:
    """How far a sensor is from the right verdicts; 0 where each state is on its side of the thresholds, with a margin.

    Args:
        reading: What was read of it.
        profile: The thresholds.

    Returns:
        The sum of what similarity lacks before and in contact, entropy of near objects and at rest, correlation of near
        objects and of the flashlight, means over the states in units of `SCALES`.
    """
    gaps, close = len(GAPS_MM), [place for place, gap in enumerate(GAPS_MM) if gap <= NEAR_MM]
    similarity, entropy, correlation = map(np.array, (reading.similarity, reading.entropy, reading.correlation))
    rest, light = reading.quantities["e_rest"], reading.quantities["c_light"]
    lacks: dict[str, tuple[Array | float, ...]] = {
        "similarity": (profile.tau_g - similarity[:gaps], similarity[gaps:] - profile.tau_g),
        "entropy": (profile.tau_e - entropy[close], rest - profile.tau_e),
        "correlation": (correlation[close] - profile.tau_c, profile.tau_c - light),
    }
    return float(
        sum(np.mean(np.maximum(0, each / SCALES[name] + MARGIN)) for name, states in lacks.items() for each in states)
    )


def _right(
    untouched: Sequence[Verdict], touched: Sequence[Verdict], close: Sequence[Verdict], light: Verdict
) -> dict[str, float]:
    return {
        "untouched": float(np.mean([each.combined is not Contact.TOUCHED for each in untouched])),
        "touched": float(np.mean([each.combined is Contact.TOUCHED for each in touched])),
        "near": float(np.mean([each.proximity is Proximity.APPROACHING for each in close])),
        "light": float(light.proximity is Proximity.NOISE),
    }


def _brightening(shot: Frame, resting: Sequence[Frame]) -> Array:
    return np.asarray(np.maximum(shot - np.mean(resting, axis=0), 0))


def scaled(profile: DetectorProfile, *, columns: int, full: int) -> DetectorProfile:
    """The profile for a smaller image: its blur covers the same part of the face."""
    size = round((profile.grid_blur_px - 1) * columns / full / 2) * 2 + 1 if profile.grid_blur_px > 1 else 0
    return replace(profile, grid_blur_px=size)
