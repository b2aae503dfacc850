"""One episode in closed loop: both fingers' frames, the angle read from them, the turn of the wrist that follows."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from magicsim.arrays import Frame
from magicsim.errors import ConfigError, ConvergenceError, MagicsimError
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.grip.truth import GripFrames
from magicsim.robot.gripper import Gripper
from magicsim_experiments.learn.reading import FrameReader
from magicsim_experiments.learn.samples import Images
from magicsim_experiments.task.alignment.grip import HOW, AlignmentConfig, Grip
from magicsim_experiments.task.settings import Item

LABEL = "r_z"
"""Angle of an object's axis to the sensor's y, in (-90, 90] [degrees], see `study.learned.alignment`."""


class AngleReader:
    """A model that tells r_z, with the untouched frames of both fingers."""

    def __init__(self, model: Path) -> None:
        """Opens a file `model.safetensors` of the study `alignment`.

        Raises:
            ConfigError: It is no model, or tells no angle; the message says how to make one.
        """
        if not model.is_file():
            raise ConfigError(f"model file '{model}' does not exist: {HOW}")
        self.reader = FrameReader(model)
        labels = [label.name for label in self.reader.config.labels]
        if LABEL not in labels:
            raise ConfigError(f"model '{model}' tells {', '.join(labels)} and not {LABEL}: {HOW}")
        self._column = labels.index(LABEL)
        self._untouched: list[Images] = []

    def learn(self, upper: Sequence[Frame], lower: Sequence[Frame]) -> None:
        """Takes the mean of both fingers' untouched frames."""
        for finger, frames in (("upper", upper), ("lower", lower)):
            self.reader.check(frames[0], f"the {finger} finger's frame")
        self._untouched = [self.reader.untouched(frames) for frames in (upper, lower)]

    def read(self, upper: Frame, lower: Frame) -> tuple[float, float]:
        """The angle about the closing axis in the gripper's frame, as each finger's frame says it [degrees].

        The lower finger sees it turned the other way.

        Raises:
            ConfigError: Nothing has been learned of the untouched fingers yet.
        """
        if not self._untouched:
            raise ConfigError("the untouched fingers are not known yet: call learn first")
        angles = self.reader.read([upper, lower], self._untouched)[:, self._column]
        return float(angles[0]), -float(angles[1])


Vector = tuple[float, float, float]


def turned_deg(wrist_deg: float, read_deg: float, *, dt_s: float, gain_per_s: float, most_deg_s: float) -> float:
    """Angle of the wrist one frame later, proportional control to 0 of the axis' angle to the vertical, as it was read.

    The speed for each degree is `gain_per_s`; at most one over the frame's time counts, which does not overshoot.
    """
    speed = -min(gain_per_s, 1 / dt_s) * read_deg
    return wrist_deg + min(max(speed, -most_deg_s), most_deg_s) * dt_s


def down_at(wrist_deg: float) -> Vector:
    """Where gravity points in the gripper's frame: to the fingertips (+y) where the wrist is at 0.

    The wrist's angle is that of the gripper in the room, about its closing axis [degrees].
    """
    turn = math.radians(wrist_deg)
    return math.sin(turn), math.cos(turn), 0.0


def line_angle_deg(angle_deg: float) -> float:
    """An angle of a line, which has no sense, in (-90, 90] [degrees]."""
    return 90 - (90 - angle_deg) % 180


Seen = Callable[[Frame, Frame, "AlignmentFrame"], None]
ROOM_MM, STEP_MM = 0.2, 0.2
"""Room on both sides together before the fingers close, and by how much they close at once [mm]."""
LONG_S = 10.0
"""Time in which the fingers reach any width [s]."""
MOST_STEPS = 15
"""Closings after which the motors must have stalled."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignmentFrame:
    """One pair of frames: what was true, and what was read."""

    episode: int
    frame: int
    time_s: float
    """From the first frame with the item in the fingers alone [s]."""
    wrist_deg: float
    """Turn of the gripper in the room [degrees]."""
    held_deg: float
    """True angle of the item in the grip [degrees]."""
    error_deg: float
    """True angle of the item's axis to the room's vertical [degrees]."""
    upper_deg: float
    """Angle in the grip as the upper finger's frame was read [degrees]."""
    lower_deg: float
    """Angle as the lower finger's frame was read, in the gripper's frame [degrees]."""
    read_deg: float
    """Mean of both [degrees]."""
    hold: str
    """`held` or `slipped`, see `magicsim.robot.Hold`."""
    upper_n: float
    """Normal force of the upper finger [N]."""
    lower_n: float
    slid_mm: float
    """Way of sliding in the last motion [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignmentRecord:
    """One episode."""

    rows: tuple[AlignmentFrame, ...]
    is_dropped: bool
    error: str
    """Why it ended early, such as that no equilibrium was found; empty otherwise."""


def play(
    gripper: Gripper, reader: AngleReader, grip: Grip, item: Item, config: AlignmentConfig, *, episode: int, seed: int,
    seen: Seen | None = None,
) -> AlignmentRecord:  # fmt: skip
    """Plays an episode.

    Raises:
        RenderError: A frame of the empty fingers is not valid; what goes wrong later ends this episode alone.
    """
    gripper.reset(seed=seed)
    for finger in gripper.fingers:
        finger.set_frame_rate(config.frames_per_second)
    rows: list[AlignmentFrame] = []
    wrist = 0.0
    learn_untouched(gripper, reader, config.references)
    try:
        take(gripper, grip)
        hold = gripper.hold(load=Load.of_mass(item.mass_g, down=down_at(wrist)))
        while hold is not Hold.DROPPED and len(rows) < config.frames:
            pair = gripper.frames()
            rows.append(_row(pair, reader, config, wrist_deg=wrist, episode=episode, frame=len(rows)))
            if seen is not None:
                seen(pair.upper.image, pair.lower.image, rows[-1])
            wrist = turned_deg(
                wrist, line_angle_deg(wrist + rows[-1].read_deg), dt_s=1 / config.frames_per_second,
                gain_per_s=config.gain_per_s, most_deg_s=config.wrist_deg_s,
            )  # fmt: skip
            if len(rows) < config.frames:
                hold = gripper.hold(load=Load.of_mass(item.mass_g, down=down_at(wrist)))
    except MagicsimError as error:
        return AlignmentRecord(rows=tuple(rows), is_dropped=False, error=str(error))
    return AlignmentRecord(rows=tuple(rows), is_dropped=hold is Hold.DROPPED, error="")


def learn_untouched(gripper: Gripper, reader: AngleReader, count: int) -> None:
    """Films the empty fingers, as wide open as the item is."""
    gripper.remove_object()
    gripper.turn_to(gripper.linkage.angle_deg(gripper.touching_width_mm), dt_s=LONG_S)
    pairs = [gripper.frames() for _ in range(count)]
    reader.learn([each.upper.image for each in pairs], [each.lower.image for each in pairs])


def take(gripper: Gripper, grip: Grip) -> None:
    """Closes the fingers on the item that a hand holds, until the motors stall.

    Raises:
        ConvergenceError: No valid equilibrium was found, or the motors do not stall.
    """
    width = gripper.touching_width_mm + ROOM_MM
    gripper.close(width, place=grip.place)
    for _ in range(MOST_STEPS):
        width -= STEP_MM
        gripper.turn_to(gripper.linkage.angle_deg(width), dt_s=LONG_S, floats=True)
        if gripper.truth().is_stalled:
            return
    raise ConvergenceError(f"the motors do not stall at {gripper.linkage.force_limit_n:g} N on '{grip.item}'")


def _row(
    pair: GripFrames, reader: AngleReader, config: AlignmentConfig, *, wrist_deg: float, episode: int, frame: int
) -> AlignmentFrame:
    truth = pair.truth
    upper, lower = reader.read(pair.upper.image, pair.lower.image)
    return AlignmentFrame(
        episode=episode, frame=frame, time_s=round(frame / config.frames_per_second, 6), wrist_deg=wrist_deg,
        held_deg=truth.place.twist_deg, error_deg=line_angle_deg(wrist_deg + truth.place.twist_deg),
        upper_deg=upper, lower_deg=lower, read_deg=(upper + lower) / 2, hold=truth.hold.value,
        upper_n=truth.upper.force_n[2], lower_n=truth.lower.force_n[2], slid_mm=truth.slid_mm,
    )  # fmt: skip
