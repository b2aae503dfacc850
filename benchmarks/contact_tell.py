"""What of a frame tells whether the object touches, although it must not: how the light was computed.

    python benchmarks/contact_tell.py --out docs/benchmarks/contact-tell.json [--cases 24] [--seed 1] [--tier fast]

Pairs of states 0.002 to 0.05 mm before and after contact are filmed with several objects, places, seeds, designs and
lights, by a camera without noise, with the flashlight off and on; so are a sensor with an object too far to be seen
and one without, and a flashlight on and off beside an object that is near, both in the dark: in a lit room the lamp
and the object cover what is behind them, which is to be seen. Deeper, the deformation itself reaches far and may be
seen; the error of the frame may not: the same states are filmed by two sensors with random numbers of their own, and
what the two frames differ by is judged, 0.3 to 2 mm deep against just before contact. Classifiers see only what must
not know: features of blocks of the image that lie 8 mm and more from the contact, where nothing physical changes
(residual noise, high-pass statistics, noise levels of blocks, sums of channels), and the size of the frame's PNG. Each
is trained on some cases and judged on others (grouped cross-validation); the area under its curve is 0.5 where nothing
is told. Intervals are a bootstrap over cases. With `--tier fast` the frames are the fast tier's, of the design and
lights that its model knows, and classifiers also tell fast frames from true ones, behind the camera as it is.
"""

import argparse
import json
import random
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

import cv2
import numpy as np
import numpy.typing as npt
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import GroupKFold
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from magicsim.camera.camera import Camera
from magicsim.camera.exposure import expose, meter
from magicsim.geometry.objects.kinds import parse_object
from magicsim.judge.measures import ends
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
Frame = npt.NDArray[np.uint8]
GAPS_MM = (0.002, 0.005, 0.01, 0.02, 0.05)
DEEP_MM = (0.3, 0.6, 1.0, 2.0)
"""Depths at which the difference of two seeds is judged."""
FAR_MM = 8.0
"""Distance from the contact where the deformation does not reach."""
BLOCK_PX = 20
MID_GREY = 128
OBJECTS = (
    "sphere:radius_mm=4,color=0.8x0.4x0.1", "sphere:radius_mm=2.5,color=0.2x0.2x0.25",
    "domed_cylinder:radius_mm=3,edge_radius_mm=1,color=0.3x0.6x0.2", "sphere:radius_mm=6,color=0.7x0.7x0.7",
)  # fmt: skip
PLACES = ((-6.0, -9.0), (6.0, 9.0), (-5.0, 8.0), (5.0, -8.0), (0.0, -10.0), (0.0, 10.0))
"""Near the rim, so that much of the image is far from the contact."""
DESIGNS = ((), ("design.cell_mm=1.0",), ("design.skin_mm=0.6",))
DIMMED = (1.0, 0.4)
"""Strength of the first LED strip."""
FAST = "render.tier=fast"
DIM = 1e-6
"""Radiance of a flashlight that changes a few of a frame's pixels by a grey level, less than any other motion does."""
CLEAN = ("rig.camera.read_noise_e=0", "rig.camera.full_well_e=1e9", "references=1")
"""The camera's own noise must not be what hides a step."""
NOISY = tuple(f"rig.camera.{name}={Camera.model_fields[name].default}" for name in ("read_noise_e", "full_well_e"))
"""That noise, where tiers are told apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Taken:
    """One frame, and where it must not know whether anything touches."""

    case: int
    label: bool
    frame: Frame
    rest: Frame
    far: list[tuple[slice, slice]]
    """Blocks of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """One frame and what a classifier may see of it."""

    case: int
    label: bool
    features: dict[str, list[float]]

    @classmethod
    def of(cls, taken: Taken) -> Self:
        """Its features."""
        return cls(case=taken.case, label=taken.label, features=features(taken.frame, taken.rest, taken.far))


@dataclass(frozen=True, slots=True, kw_only=True)
class Filmed:
    """A sensor whose frames are exposed as it is at rest, without noise."""

    sensor: Sensor
    gain: Array
    rest: Frame

    @classmethod
    def by(cls, sensor: Sensor) -> Self:
        """The sensor's own exposure."""
        untouched = sensor.radiance(UNTOUCHED, sensor.rest)
        exposure = meter(untouched, sensor.rig.camera)
        return cls(sensor=sensor, gain=exposure, rest=expose(untouched, exposure, sensor.rig.camera, seed=0, frame=0))

    def frame(self, state: FrameState, *, seed: int = 0) -> Frame:
        """Solved where it touches, rendered and exposed with the noise of a seed."""
        deformation = self.sensor.deform(state, self.sensor.rest) if state.can_touch else self.sensor.rest
        radiance = self.sensor.radiance(state, deformation)
        return expose(radiance, self.gain, self.sensor.rig.camera, seed=seed, frame=0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """Object, place, design and light of one case."""

    sensor: Sensor
    chance: random.Random
    x_mm: float
    y_mm: float
    far: list[tuple[slice, slice]]

    def state(self, gap_mm: float | None, *, flashlight: bool = False, light_x_mm: float = 0.0) -> FrameState:
        """The object at its place."""
        return FrameState(
            gap_mm=gap_mm, x_mm=self.x_mm, y_mm=self.y_mm, twist_deg=0.0, flashlight=flashlight, light_x_mm=light_x_mm
        )


def drawn(case: int, seed: int, settings: Sequence[str], block_px: int, *, deepest_mm: float) -> Drawn:
    """One case, see `film`."""
    chance = random.Random(1000 * seed + case)
    x_mm, y_mm = chance.choice(PLACES)
    deepest = f"keyframes=[{{frame=0,gap_mm=-{deepest_mm},x_mm={x_mm},y_mm={y_mm}}}]"
    design, share = chance.choice(DESIGNS), chance.choice(DIMMED)
    if FAST in settings:
        design, share = (), 1.0  # what its model knows
    scene = load_scene("pressed", [*CLEAN, *settings, *design, deepest], seed=100 * seed + case)
    first, *others = scene.rig.strips
    dimmed = first.model_copy(update={"radiance": tuple(share * each for each in first.radiance)})
    rig = scene.rig.model_copy(update={"strips": (dimmed, *others)})
    sensor = Sensor.for_scene(scene.model_copy(update={"rig": rig, "object": parse_object(chance.choice(OBJECTS))}))
    return Drawn(
        sensor=sensor, chance=chance, x_mm=x_mm, y_mm=y_mm,
        far=_far_blocks(sensor.rig.camera, x_mm, y_mm, block_px),
    )  # fmt: skip


def film(case: int, seed: int, settings: Sequence[str] = (), block_px: int = BLOCK_PX) -> Iterator[tuple[str, Taken]]:
    """Frames of one case, with the question that they belong to.

    Args:
        case: Draws object, place, design and light.
        seed: Of all cases.
        settings: Overrides of the scene.
        block_px: Edge of the blocks that are looked at [px].
    """
    each = drawn(case, seed, settings, block_px, deepest_mm=GAPS_MM[-1])
    sensor, rig, chance = each.sensor, each.sensor.rig, each.chance

    def taken(filmed: Filmed, state: FrameState, *, label: bool) -> Taken:
        return Taken(case=case, label=label, frame=filmed.frame(state), rest=filmed.rest, far=each.far)

    lit = Filmed.by(sensor)
    for question, shining in (("before or after contact", False), ("before or after contact, flashlight on", True)):
        for gap_mm in GAPS_MM:
            for sign in (1, -1):
                yield question, taken(lit, each.state(sign * gap_mm, flashlight=shining), label=sign < 0)
    dim = rig.flashlight.model_copy(update={"radiance": (DIM,) * 3})
    sensor = sensor.with_rig(rig.model_copy(update={"flashlight": dim, "room": None, "ambient": (0.0,) * 3}))
    sensor.renderer.metered()
    dark = Filmed.by(sensor)
    for shining in (False, True) * 3:
        state = each.state(chance.uniform(0.5, 3), flashlight=shining, light_x_mm=chance.uniform(-4, 4))
        yield "flashlight off, or on and too dim to be seen", taken(dark, state, label=shining)
    for gap_mm in (None, 1700.0, 1900.0):
        yield "absent or too far to be seen", taken(dark, each.state(gap_mm), label=gap_mm is not None)


def film_twice(
    case: int, seed: int, settings: Sequence[str] = (), block_px: int = BLOCK_PX
) -> Iterator[tuple[str, Taken]]:
    """What frames of one state by two seeds differ by, around mid grey, with its question; see `film`."""
    each = drawn(case, seed, settings, block_px, deepest_mm=1.03 * DEEP_MM[-1])
    first, second = Filmed.by(each.sensor), Filmed.by(each.sensor.reseeded(1))
    grey = np.full_like(first.rest, MID_GREY)

    def taken(gap_mm: float) -> Taken:
        one, two = (filmed.frame(each.state(gap_mm)).astype(np.int16) for filmed in (first, second))
        difference = np.clip(one - two + MID_GREY, 0, 255).astype(np.uint8)
        return Taken(case=case, label=gap_mm < 0, frame=difference, rest=grey, far=each.far)

    near = [taken(gap_mm) for gap_mm in GAPS_MM[:2]]
    for depth_mm in DEEP_MM:
        question = f"difference of two seeds, just before contact or {depth_mm} mm deep"
        for shown in [*near, taken(-depth_mm), taken(-1.03 * depth_mm)]:
            yield question, shown


def film_tiers(case: int, seed: int, block_px: int = BLOCK_PX) -> Iterator[tuple[str, Taken]]:
    """Frames of one case by the fast tier and by the true one, with the camera's own noise; see `film`."""
    each = drawn(case, seed, (FAST, *NOISY), block_px, deepest_mm=1.03 * DEEP_MM[-1])
    settings = each.sensor.settings.model_copy(update={"tier": "true"})
    true = Sensor(
        each.sensor.design, each.sensor.rig, each.sensor.object, render=settings, states=each.sensor.states,
        seed=each.sensor.seed,
    )  # fmt: skip
    tiers = (Filmed.by(true), Filmed.by(each.sensor))
    for number, gap_mm in enumerate((GAPS_MM[-1], *(-depth_mm for depth_mm in DEEP_MM))):
        for label, filmed in enumerate(tiers):
            frame = filmed.frame(each.state(gap_mm), seed=2 * number + label + 1)
            taken = Taken(case=case, label=bool(label), frame=frame, rest=tiers[0].rest, far=each.far)
            yield f"fast or true, {gap_mm} mm away (negative: pressed)", taken


def _far_blocks(camera: Camera, x_mm: float, y_mm: float, block_px: int) -> list[tuple[slice, slice]]:
    """Blocks of the image that are far from a place of the contact face; row 0 is at the top, +y."""
    pixel_mm = camera.field_mm / camera.columns
    blocks = []
    for top in range(0, camera.rows - block_px + 1, block_px):
        for left in range(0, camera.columns - block_px + 1, block_px):
            across = (left + block_px / 2 - camera.columns / 2) * pixel_mm
            down = (top + block_px / 2 - camera.rows / 2) * pixel_mm
            # Whichever way the image is mirrored, the block is far from the contact.
            if min(np.hypot(across - a * x_mm, down - b * y_mm) for a in (-1, 1) for b in (-1, 1)) > FAR_MM:
                blocks.append((slice(top, top + block_px), slice(left, left + block_px)))
    return blocks


def features(frame: Frame, rest: Frame, far: list[tuple[slice, slice]]) -> dict[str, list[float]]:
    """Numbers that must not know whether anything touches, by kind."""
    change = frame.astype(np.float64) - rest
    residual = change - _of_neighbours(change)
    high = frame - _of_neighbours(frame.astype(np.float64))
    levels = np.array([residual[block].std((0, 1)) for block in far])
    fine = np.array([high[block].std((0, 1)) for block in far])
    sums = np.array([change[block].mean((0, 1)) for block in far])
    return {
        "residual noise": [*levels.mean(0), *np.abs(residual[far[0]]).mean((0, 1))],
        "high-pass statistics": [*fine.mean(0), *(high**4).mean((0, 1))],
        "noise levels of blocks": [*np.quantile(levels, (0.1, 0.5, 0.9), axis=0).ravel()],
        "sums of channels": [*sums.mean(0), *sums.std(0)],
        "size of the PNG": [float(len(cv2.imencode(".png", frame)[1]))],
    }


def _of_neighbours(image: Array) -> Array:
    """Mean of the four neighbours of each pixel."""
    return sum(np.roll(image, step, axis) for step in (-1, 1) for axis in (0, 1)) / 4


def judge(frames: list[Shown], kind: str, chance: np.random.Generator) -> dict[str, float]:
    """The better of two classifiers' areas under the curve, its bootstrap interval over cases."""
    values = np.array([each.features[kind] for each in frames])
    labels, cases = np.array([each.label for each in frames]), np.array([each.case for each in frames])
    best: dict[str, float] = {}
    for make in (
        lambda: make_pipeline(StandardScaler(), LogisticRegression(max_iter=1000)),
        lambda: HistGradientBoostingClassifier(max_iter=60, min_samples_leaf=5, random_state=0),
    ):
        scores = np.zeros(len(frames))
        for train, test in GroupKFold(min(6, len(set(cases)))).split(values, labels, cases):
            model = make().fit(values[train], labels[train])
            scores[test] = model.predict_proba(values[test])[:, 1]
        drawn = []
        for _ in range(400):
            chosen = np.concatenate(
                [np.flatnonzero(cases == case) for case in chance.choice(np.unique(cases), len(set(cases)))]
            )
            if len(set(labels[chosen])) > 1:
                drawn.append(roc_auc_score(labels[chosen], scores[chosen]))
        low, high = ends(np.array(drawn))
        found = {"auc": float(roc_auc_score(labels, scores)), "low": low, "high": high}
        if not best or abs(found["auc"] - 0.5) > abs(best["auc"] - 0.5):
            best = found
    return best


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tier", choices=("true", "fast"), default="true")
    chosen = parser.parse_args()
    frames: dict[str, list[Shown]] = {}
    settings = (FAST,) if chosen.tier == "fast" else ()
    for case in range(chosen.cases):
        shown = [*film(case, chosen.seed, settings), *film_twice(case, chosen.seed, settings)]
        for question, taken in shown + (list(film_tiers(case, chosen.seed)) if settings else []):
            frames.setdefault(question, []).append(Shown.of(taken))
        print(json.dumps({"case": case, "frames": sum(map(len, frames.values()))}), flush=True)
    chance = np.random.default_rng(chosen.seed)
    rows = [
        {"question": question, "seen": kind, "frames": len(each), **judge(each, kind, chance)}
        for question, each in frames.items()
        for kind in each[0].features
    ]
    for row in rows:
        print(json.dumps(row))
    about = {
        "cases": chosen.cases, "seed": chosen.seed, "tier": chosen.tier, "gaps_mm": GAPS_MM, "deep_mm": DEEP_MM,
        "far_mm": FAR_MM,
    }  # fmt: skip
    chosen.out.write_text(json.dumps({"settings": about, "results": rows}, indent=1) + "\n")
    # Every frame's features, to look into, beside it.
    raw = [asdict(shown) | {"question": question} for question, each in frames.items() for shown in each]
    chosen.out.with_suffix(".frames.jsonl").write_text("".join(json.dumps(each, default=bool) + "\n" for each in raw))


if __name__ == "__main__":
    main()
