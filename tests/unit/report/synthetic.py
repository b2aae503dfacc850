"""A made-up episode: no renderer, no solver, but a story with every class in it."""

from collections.abc import Sequence

import numpy as np

from magicsim.detectors.combined import judge
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Verdict
from magicsim.frame_class import FrameClass, classify_frame
from magicsim.judge.score import score_verdicts
from magicsim.judge.verdicts import Judgement
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.simulation.episode import Episode, FrameLabels, FrameTruth, SimulatedFrame, SolveFigures

DESIGN = {
    "schema_version": 1,
    "footprint_mm": [24.0, 32.0],
    "skin_mm": 0.8,
    "core_mm": 5.0,
    "cell_mm": 0.0,
    "materials": {"body": {"ior": 1.49, "youngs_modulus_mpa": 1.1, "poisson_ratio": 0.49}},
}
RIG = {"schema_version": 1, "strips": [{"side": "-x", "radiance": [5.0, 0.0, 0.0]}]}
STORY = [
    {"frame": 0},
    {"frame": 8, "gap_mm": 20.0},
    {"frame": 20, "gap_mm": 3.0},
    {"frame": 30, "gap_mm": 0.0},
    {"frame": 44, "gap_mm": -1.4},
    {"frame": 54, "gap_mm": -1.4, "x_mm": 1.0},
    {"frame": 66, "gap_mm": 0.0, "x_mm": 1.0},
    {"frame": 74, "gap_mm": 20.0, "x_mm": 1.0},
    {"frame": 76},
    {"frame": 80, "flashlight": True, "light_x_mm": -4.0},
    {"frame": 89, "flashlight": True, "light_x_mm": 4.0},
]


def make_episode(
    keyframes: Sequence[dict[str, object]] = STORY,
    *,
    references: int = 3,
    size: tuple[int, int] = (32, 24),
    **scene: object,
) -> Episode:
    radius = {"kind": "sphere", "radius_mm": 5.0}
    config = SceneConfig.model_validate(
        {"schema_version": 1, "design": DESIGN, "rig": RIG, "seed": 7, "references": references}
        | ({"object": radius} if any("gap_mm" in each for each in keyframes) else {})
        | {"keyframes": list(keyframes)}
        | scene
    )
    states = [*[UNTOUCHED] * references, *timeline(config)]
    return Episode(
        scene=config,
        frames=tuple(
            _frame(config, k, state, is_reference=k < references, size=size) for k, state in enumerate(states)
        ),
    )


def make_judgement(
    episode: Episode, profile: str = "calibrated", *, tau_e: float = 1.2, tau_g: float = 0.8
) -> Judgement:
    used = DetectorProfile(tau_e=tau_e, tau_c=0.6, tau_g=tau_g)
    verdicts = tuple(_verdict(frame, used) for frame in episode.scored)
    return Judgement(
        profile=profile,
        thresholds={"tau_e": used.tau_e, "tau_c": used.tau_c, "tau_g": used.tau_g},
        verdicts=verdicts,
        score=score_verdicts(verdicts, [frame.truth.frame_class for frame in episode.scored]),
    )


def _verdict(frame: SimulatedFrame, profile: DetectorProfile) -> Verdict:
    rng = np.random.default_rng([1, frame.truth.index])
    state, noise = frame.truth.state, 0.06 * rng.standard_normal(3)
    gap = state.gap_mm
    nearness = 0.0 if gap is None else float(np.exp(-max(gap, 0.0) / 3.0))
    light = float(state.flashlight)
    return judge(
        entropy=max(0.0, 0.8 + 2.2 * nearness + 5.4 * light + noise[0]),
        correlation=float(np.clip(0.1 + 0.25 * nearness + 0.85 * light + noise[1], -1.0, 1.0)),
        similarity=float(
            np.clip(0.98 - 0.05 * nearness - 0.3 * frame.truth.depth_mm - 0.8 * light + 0.2 * noise[2], 0.0, 1.0)
        ),
        profile=profile,
    )


def _frame(
    config: SceneConfig, index: int, state: FrameState, *, is_reference: bool, size: tuple[int, int]
) -> SimulatedFrame:
    depth = max(0.0, -state.gap_mm) if state.gap_mm is not None else 0.0
    force = 0.9 * depth**1.5
    solved = depth > 0.0
    return SimulatedFrame(
        image=_image(index, state, depth, size),
        truth=FrameTruth(
            index=index,
            time_s=index / config.frames_per_second,
            is_reference=is_reference,
            state=state,
            contact=solved,
            depth_mm=depth,
            force_n=(0.3 * state.x_mm * depth, 0.0, force),
            torque_nmm=(0.0, 0.0, 0.0),
            contact_area_mm2=10.0 * depth,
            frame_class=classify_frame(
                gap_mm=state.gap_mm, force_n=force, light_on=state.flashlight, is_reference=is_reference
            ),
            solve=SolveFigures(
                iterations=4 + index % 5 if solved else 0,
                min_jacobian=1.0 - 0.2 * depth,
                max_penetration_mm=1e-6 * depth,
                force_balance=3e-8 if solved else 0.0,
            ),
        ),
        labels=FrameLabels(),
    )


def _image(index: int, state: FrameState, depth: float, size: tuple[int, int]) -> np.ndarray:
    rows, columns = np.mgrid[-1.0 : 1.0 : size[0] * 1j, -1.0 : 1.0 : size[1] * 1j]
    grid = 0.6 + 0.4 * ((np.cos(28.0 * rows) > -0.6) & (np.cos(21.0 * columns) > -0.6))
    image = np.stack([90.0 - 50.0 * columns, 70.0 + 30.0 * rows**2, 90.0 + 50.0 * columns], axis=-1) * grid[..., None]
    if state.gap_mm is not None:
        spread = 0.15 + 0.05 * max(state.gap_mm, 0.0) + 0.1 * depth
        spot = np.exp(-((columns - 0.1 * state.x_mm) ** 2 + rows**2) / spread)
        image = image + (60.0 + 60.0 * depth) / (1.0 + max(state.gap_mm, 0.0)) * spot[..., None]
    if state.flashlight:
        image = image + 110.0 * np.exp(-((columns - 0.2 * state.light_x_mm) ** 2 + rows**2))[..., None]
    noise = 2.0 * np.random.default_rng([0, index]).standard_normal(image.shape)
    return np.clip(image + noise, 0.0, 255.0).astype(np.uint8)


def classes_of(episode: Episode) -> set[FrameClass]:
    return {frame.truth.frame_class for frame in episode.scored if frame.truth.frame_class}
