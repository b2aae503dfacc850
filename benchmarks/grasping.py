"""The grasp state machine over seeded episodes: does it complete, how soon is a slip seen, does light fool it?

    python benchmarks/grasping.py --episodes 50 --out grasping.jsonl     # goes on where it was cut off
    python benchmarks/grasping.py --episodes 3 --set render.particles=40000 --profile my.toml

Each episode of the default sensor is drawn from its seed alone: object, colour, place, depth, speed and light. In it a
flashlight comes and goes, an object approaches, is pressed and held (in every other episode with a flashlight on it),
is torn away from one frame to the next, leaves, and the flashlight comes again. The machine sees frames only and moves
nothing; objects press along z, without friction. The file keeps the features of every frame, one episode a line, so
that a run that is cut off goes on and other thresholds or another machine are tried without rendering again (`--judge
profile.toml`, with the options that the features were measured with).
"""

import argparse
import json
import logging
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from magicsim.detectors import DetectorProfile, detect_all, fuse, load_profile, run_grasp
from magicsim.detectors.combined import judge
from magicsim.geometry.objects.kinds import parse_object
from magicsim.light.records.untouched_states import shared_states
from magicsim.scenes.scene import Keyframe, SceneConfig, load_scene
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import simulate_with

OBJECTS = (
    "sphere:radius_mm={size}", "cylinder:radius_mm={size},length_mm=14,axis=y,edge_radius_mm=0.5",
    "box:size_mm={wide}x{wide}x10,edge_radius_mm=0.5", "punch:radius_mm={size},edge_radius_mm=0.5",
)  # fmt: skip
FRICTIONLESS = "contact.friction=0"
QUIET = ("output.contact_mask=false", "output.displacements=false", "output.preview=false", "output.report=false")
SLIP_WITHIN = 5
"""Frames after the release within which a slip must be seen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspScene:
    """One drawn episode."""

    scene: SceneConfig
    object_text: str
    depth_mm: float
    release: int
    """First frame after the object was torn away."""
    lights: dict[str, tuple[int, int]]
    """First frame and the one after the last of every flashlight: `before`, `held` (where there is one), `after`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspRecording:
    """One rendered episode, as a line of the file."""

    seed: int
    profile: str
    """Profile whose options measured the features."""
    object_text: str
    depth_mm: float
    release: int
    lights: dict[str, tuple[int, int]]
    gaps_mm: list[float | None]
    """True gap of every frame [mm], None without an object."""
    features: list[tuple[float, float, float]]
    """Entropy [bit], correlation and similarity of every frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspOutcome:
    """What the machine made of one episode."""

    seed: int
    object_text: str
    depth_mm: float
    completed: bool
    """Closed, grasped and transported before the release, slipped after it, and waits at the end."""
    closed_at_gap_mm: float | None
    """Gap when the gripper began to close [mm]; None if it never did with an object there."""
    frames_before_contact: int | None
    """Frames from there to first contact."""
    slip_delay_frames: int | None
    """Frames from the release to the slip, 0 in the first frame after it; None if it was not seen."""
    false_slips: int
    """Slips while the object was held."""
    false_closes: int
    """Closings without an object in the scene."""
    lights_obeyed: dict[str, bool]
    """For every flashlight whether it changed the stage, until two frames after it."""
    noise_share: dict[str, float]
    """For every flashlight the share of its frames that proximity called Noise."""
    stages: str
    """Initials of the stages frame by frame."""


def draw_scene(seed: int, overrides: Sequence[str]) -> GraspScene:
    """The episode of one seed."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 7]))
    size = float(rng.uniform(2.5, 5.0))
    color = "x".join(f"{value:.2f}" for value in rng.uniform(0.15, 0.85, 3))
    template = OBJECTS[int(rng.integers(len(OBJECTS)))]
    text = template.format(size=f"{size:.2f}", wide=f"{2 * size:.2f}") + f",color={color}"
    x, y = (float(rng.uniform(-reach, reach)) for reach in (3.0, 5.0))
    depth = float(rng.uniform(0.6, 1.4))
    approach, press, hold = (int(rng.integers(low, high)) for low, high in ((10, 15), (3, 6), (8, 12)))
    light_x = rng.uniform(-8.0, 8.0, 3)
    keys: list[Keyframe] = []
    lights: dict[str, tuple[int, int]] = {}

    def at(frame: int, gap: float | None = None, light: int | None = None) -> None:
        keys.append(
            Keyframe(
                frame=frame,
                gap_mm=None if gap is None else round(gap, 3),
                x_mm=0.0 if gap is None else round(x, 3),
                y_mm=0.0 if gap is None else round(y, 3),
                flashlight=light is not None,
                light_x_mm=0.0 if light is None else round(float(light_x[light]), 3),
            )
        )

    at(0)
    at(3, light=0)
    lights["before"] = (3, 3 + int(rng.integers(6, 10)))
    at(lights["before"][1])
    near = lights["before"][1] + 4
    at(near, 25.0)
    at(near + approach // 2, 3.0)
    touch = near + approach
    at(touch, 0.05)
    held = touch + press
    at(held, -depth)
    release = held + hold + 6
    if seed % 2:
        lights["held"] = (held + hold, held + hold + 3)
        at(held + hold, -depth, light=1)
        at(held + hold + 3, -depth)
    at(release - 1, -depth)
    at(release, float(rng.uniform(2.0, 12.0)))
    at(release + 3)
    lights["after"] = (release + 11, release + 17)
    at(release + 11, light=2)
    at(release + 17)
    at(release + 20)
    scene = load_scene("demo", [FRICTIONLESS, *QUIET, *overrides], seed=seed)
    scene = scene.model_copy(update={"object": parse_object(text), "keyframes": tuple(keys)})
    return GraspScene(scene=scene, object_text=text, depth_mm=round(depth, 3), release=release, lights=lights)


def record_episode(seed: int, name: str, overrides: Sequence[str]) -> GraspRecording:
    """Simulates one episode and measures its frames."""
    drawn, profile = draw_scene(seed, overrides), load_profile(name)
    episode = simulate_with(Sensor.for_scene(drawn.scene, untouched=shared_states()), plan_scene(drawn.scene))
    references = fuse([frame.image for frame in episode.references], profile)
    verdicts = detect_all([frame.image for frame in episode.scored], references, profile)
    return GraspRecording(
        seed=seed,
        profile=name,
        object_text=drawn.object_text,
        depth_mm=drawn.depth_mm,
        release=drawn.release,
        lights=drawn.lights,
        gaps_mm=[frame.truth.state.gap_mm for frame in episode.scored],
        features=[(one.entropy, one.correlation, one.similarity) for one in verdicts],
    )


def judge_run(recording: GraspRecording, profile: DetectorProfile) -> GraspOutcome:
    """Runs the machine over an episode's frames and holds it against the truth."""
    verdicts = [
        judge(entropy=entropy, correlation=correlation, similarity=similarity, profile=profile)
        for entropy, correlation, similarity in recording.features
    ]
    gaps = recording.gaps_mm
    stages = [state.stage.value for state in run_grasp(verdicts, profile)]
    starts = [k for k, stage in enumerate(stages) if k == 0 or stages[k - 1] != stage]
    closes = [k for k in starts if stages[k] == "Closing"]
    slips = [k for k in starts if stages[k] == "Slipped"]
    real = next((k for k in closes if gaps[k] is not None), None)
    touch = next(k for k, gap in enumerate(gaps) if gap is not None and gap < 0)
    slip = next((k for k in slips if k >= recording.release), None)
    before = {stages[k] for k in starts if k < recording.release}
    return GraspOutcome(
        seed=recording.seed,
        object_text=recording.object_text,
        depth_mm=recording.depth_mm,
        completed={"Closing", "Grasped", "Transporting"} <= before and slip is not None and stages[-1] == "Waiting",
        closed_at_gap_mm=None if real is None else gaps[real],
        frames_before_contact=None if real is None else touch - real,
        slip_delay_frames=None if slip is None else slip - recording.release,
        false_slips=sum(k < recording.release for k in slips),
        false_closes=sum(gaps[k] is None for k in closes),
        lights_obeyed={
            kind: any(stages[k] != stages[k - 1] and gaps[k] == gaps[k - 1] for k in range(start, end + 2))
            for kind, (start, end) in recording.lights.items()
        },
        noise_share={
            kind: sum(one.proximity.value == "Noise" for one in verdicts[start:end]) / (end - start)
            for kind, (start, end) in recording.lights.items()
        },
        stages="".join(stage[0] for stage in stages),
    )


def summary(outcomes: Sequence[GraspOutcome]) -> dict[str, object]:
    """Shares of the episodes with exact (Clopper-Pearson) 95 % intervals."""
    delays = [each.slip_delay_frames for each in outcomes]
    counted = {
        "completed": sum(each.completed for each in outcomes),
        "slip_within_5_frames": sum(delay is not None and delay < SLIP_WITHIN for delay in delays),
        "no_false_slip": sum(not each.false_slips for each in outcomes),
        "no_false_close": sum(not each.false_closes for each in outcomes),
        "every_light_ignored": sum(not any(each.lights_obeyed.values()) for each in outcomes),
    }
    return {
        "episodes": len(outcomes),
        **{name: {"count": count, "share_95": interval(count, len(outcomes))} for name, count in counted.items()},
        "slip_delays_frames": delays,
        "frames_before_contact": [each.frames_before_contact for each in outcomes],
    }


def interval(count: int, total: int) -> list[float]:
    """Limits of a share."""
    found = binomtest(count, total).proportion_ci(0.95)
    return [round(float(found.low), 3), round(float(found.high), 3)]


def main() -> None:
    """Runs what is missing and prints the summary as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=50)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--profile", default="calibrated")
    parser.add_argument("--judge", help="profile that judges; the one that measures by default")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--out", type=Path, default=Path("grasping.jsonl"))
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    profile = load_profile(arguments.judge or arguments.profile)
    lines = arguments.out.read_text(encoding="utf-8").splitlines() if arguments.out.exists() else []
    done = {each.seed: each for each in (GraspRecording(**json.loads(line)) for line in lines)}
    outcomes = []
    for seed in range(arguments.first_seed, arguments.first_seed + arguments.episodes):
        if seed not in done:
            done[seed] = record_episode(seed, arguments.profile, arguments.settings)
            with arguments.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(done[seed])) + "\n")
        outcomes.append(judge_run(done[seed], profile))
        logging.info("%s", outcomes[-1])
    print(json.dumps(summary(outcomes), indent=1))


if __name__ == "__main__":
    main()
