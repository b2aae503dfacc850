"""The wrist: it turns gripper and object about the closing axis, and gravity turns the other way in their frame."""

import math

Vector = tuple[float, float, float]


def turned_deg(wrist_deg: float, read_deg: float, *, dt_s: float, gain_per_s: float, most_deg_s: float) -> float:
    """Angle of the wrist one frame later, proportional control of what is read to 0.

    Args:
        wrist_deg: Now [degrees].
        read_deg: Angle of the object's axis to the room's vertical, as it was read [degrees].
        dt_s: Time of a frame [s].
        gain_per_s: Speed for each degree [1/s]; at most one over the frame's time counts, which does not overshoot.
        most_deg_s: Largest speed [degrees/s].
    """
    speed = -min(gain_per_s, 1 / dt_s) * read_deg
    return wrist_deg + min(max(speed, -most_deg_s), most_deg_s) * dt_s


def down_at(wrist_deg: float) -> Vector:
    """Where gravity points in the gripper's frame: to the fingertips (+y) where the wrist is at 0.

    Args:
        wrist_deg: Angle of the gripper in the room, about its closing axis [degrees].
    """
    turn = math.radians(wrist_deg)
    return math.sin(turn), math.cos(turn), 0.0


def line_angle_deg(angle_deg: float) -> float:
    """An angle of a line, which has no sense, in (-90, 90] [degrees]."""
    return 90 - (90 - angle_deg) % 180
