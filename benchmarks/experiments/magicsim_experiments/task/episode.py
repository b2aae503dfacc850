"""One episode in closed loop: a frame, the machine's verdict on it, and the motion that follows.

The carriage between A and B: bounded speed and acceleration, along the gripper's x.
"""

from collections.abc import Callable
from dataclasses import dataclass

from magicsim.arrays import Frame
from magicsim.detectors.combined import detect
from magicsim.detectors.grasp import GraspStage, GraspState, step_grasp
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.rest import fuse
from magicsim.detectors.verdict import Verdict
from magicsim.errors import MagicsimError
from magicsim_experiments.task.world import Command, Happened, World

RELEASE_FRAMES = 2
"""Frames at B before the gripper opens on purpose."""


def command(stage: GraspStage, *, is_open: bool) -> Command:
    """What to do in a stage: closing ends where the motors stall; the carriage goes back with open fingers only."""
    if stage is GraspStage.WAITING:
        return Command(fingers="stay" if is_open else "open", carriage="to_a")
    if stage is GraspStage.TRANSPORTING:
        return Command(fingers="close", carriage="to_b")
    if stage in (GraspStage.CLOSING, GraspStage.GRASPED):
        return Command(fingers="close", carriage="stay")
    return Command(fingers="open", carriage="to_a" if is_open else "stay")


AFTER_FRAMES = 3
"""Frames after the machine waits again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspFrame:
    """One frame as it was, as the machine read it, and what it led to."""

    episode: int
    frame: int
    time_s: float
    """From the first scored frame [s]."""
    stage: str
    """Stage of the machine after the frame."""
    entropy: float
    correlation: float
    similarity: float
    proximity: str
    contact: str
    """Combined verdict."""
    event: str
    """What happened since the frame before, see `magicsim_experiments.task.world.Happened`."""
    has_item: bool
    hold: str
    """`placed`, `held`, `slipped`, `dropped` or `away`, see `magicsim.robot.Hold`."""
    gap_mm: float | None
    """Gap of the watched finger [mm]; None without an item."""
    width_mm: float
    """Distance of the contact faces [mm]."""
    carriage_mm: float
    upper_n: float
    """Normal force of the watched finger [N]."""
    lower_n: float
    """Force of the other one [N]."""
    slid_mm: float
    """Way of sliding in the last motion [mm]."""
    light: bool
    hand_mm: float | None = None
    """How far a hand is from where it holds the item [mm]; None while none is near."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspRecord:
    """One episode."""

    rows: tuple[GraspFrame, ...]
    error: str
    """Why it ended early, such as that no equilibrium was found; empty otherwise."""


def play(
    world: World, profile: DetectorProfile, *, episode: int, seed: int,
    seen: Callable[[Frame, GraspFrame], None] | None = None,
) -> GraspRecord:  # fmt: skip
    """Plays an episode; the machine reads the upper finger's frames.

    Raises:
        MagicsimError: The fingers cannot be filmed at all; what goes wrong later ends this episode alone.
    """
    finger, rate = world.gripper.upper, world.config.frames_per_second
    away = finger.now()
    finger.reset(seed=seed)
    finger.set_frame_rate(rate)
    finger.go_back(away)
    references = fuse([finger.frame().image for _ in range(profile.reference_count)], profile)
    rows: list[GraspFrame] = []
    machine, happened, at_b, idle = GraspState(), Happened(), 0, 0
    for frame in range(world.config.most_frames):
        try:
            image = finger.frame().image
        except MagicsimError as error:
            if not rows:
                raise
            return GraspRecord(rows=tuple(rows), error=str(error))
        verdict = detect(image, references, profile)
        at_b = at_b + 1 if world.is_at_b and machine.stage is GraspStage.TRANSPORTING else 0
        opening = at_b > RELEASE_FRAMES
        machine = step_grasp(machine, verdict, profile, opening=opening)
        rows.append(_row(world, verdict, machine.stage, happened, episode=episode, frame=frame))
        if seen is not None:
            seen(image, rows[-1])
        idle = idle + 1 if _is_over(rows, machine.stage) else 0
        if idle > AFTER_FRAMES:
            break
        try:
            delivered = world.deliver() if opening else ""
            happened = world.step(machine.stage, command(machine.stage, is_open=world.is_open))
        except MagicsimError as error:
            return GraspRecord(rows=tuple(rows), error=str(error))
        if delivered:
            happened = Happened(event=delivered, light=happened.light)
    return GraspRecord(rows=tuple(rows), error="")


def _is_over(rows: list[GraspFrame], stage: GraspStage) -> bool:
    """Whether the machine waits again at A after the item came and went, or was withdrawn."""
    gone = any(row.event in {"delivered", "pulled", "dropped", "withdrawn"} for row in rows)
    return gone and stage is GraspStage.WAITING and rows[-1].carriage_mm == 0


def _row(
    world: World, verdict: Verdict, stage: GraspStage, happened: Happened, *, episode: int, frame: int
) -> GraspFrame:  # fmt: skip
    truth = world.gripper.truth()
    return GraspFrame(
        episode=episode, frame=frame, time_s=round(frame / world.config.frames_per_second, 6), stage=stage.value,
        entropy=float(verdict.entropy), correlation=float(verdict.correlation), similarity=float(verdict.similarity),
        proximity=verdict.proximity.value, contact=verdict.combined.value, event=happened.event,
        has_item=world.has_item, hold=truth.hold.value, gap_mm=truth.upper.state.gap_mm, width_mm=truth.width_mm,
        carriage_mm=world.carriage.place_mm, upper_n=truth.upper.force_n[2], lower_n=truth.lower.force_n[2],
        slid_mm=truth.slid_mm, light=happened.light, hand_mm=world.hand_mm,
    )  # fmt: skip
