"""An object of some weight between two fingers that close and rise: what friction carries, what slips, what falls.

The finger's y axis points up. Both fingers are alike and the object is symmetric under half a turn about y, so one
finger is solved and each carries half: the object hangs on 2 x the upward friction of one finger. On the table the
object stays until friction carries all of its weight. In the air it sits where friction equals the weight; the height
of that place is found by solving the contact for it. Where Coulomb's law allows no such place the object falls, with
the acceleration that its unbalanced weight gives it, until friction catches it or the table does. Nothing else moves
it: its inertia at a constant speed and its rotation are left out.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from scipy.optimize import brentq

from magicsim.robot.live import LiveSensor
from magicsim.robot.moment import Moment

GRAVITY_MM_S2 = 9806.65
BALANCE_SHARE = 0.01
"""Difference of friction and weight, in units of the weight, at which the object hangs."""
FIRST_RISE_MM, MOST_RISE_MM = 0.05, 1.0
"""Search upwards for the place where the object hangs [mm]: least first step, doubled until it is too high; its end."""
FINEST_MM = 1e-6
FINGERS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class LiftState:
    """Where fingers and object are."""

    gap_mm: float
    """Distance of the object's side from each contact face [mm], negative when pressed."""
    finger_mm: float = 0.0
    """Height of the fingers above where they started [mm]."""
    object_mm: float = 0.0
    """Height of the object above the table [mm]."""
    falling_mm_s: float = 0.0
    """Speed at which the object falls, 0 while it stands or hangs [mm/s]."""
    carried_n: float = 0.0
    """Upward friction of both fingers on the object [N]; negative when they push it down."""
    normal_n: float = 0.0
    """Normal force of each finger [N]."""
    slip_share: float = 0.0
    """Share of the normal force on sliding points, 0..1."""
    slip_mm: float = 0.0
    """How far the skin slid over the object in the last step [mm]."""
    has_dropped: bool = False
    """Whether the object fell back to the table in the last step."""


class Lift:
    """One object between the fingers, moved by `step`."""

    def __init__(
        self, live: LiveSensor, *, weight_n: float, gap_mm: float, x_mm: float = 0.0, y_mm: float = 0.0
    ) -> None:
        """Places the object on the table between open fingers.

        Args:
            live: One of the fingers; its scene has the object and the friction.
            weight_n: Of the object [N].
            gap_mm: Distance of its sides from the faces [mm].
            x_mm: Its origin in the finger's frame [mm].
            y_mm: Likewise along y, while fingers and object are at height 0 [mm].

        Raises:
            ConfigError: The place is outside of the sensor's workspace.
        """
        self.live, self.weight_n = live, weight_n
        self._y_mm = y_mm
        live.move_to(gap_mm=gap_mm, x_mm=x_mm, y_mm=y_mm)
        self.state = LiftState(gap_mm=gap_mm)

    def step(self, *, closing_mm: float, rising_mm: float, dt_s: float) -> LiftState:
        """Moves both fingers and finds where the object is afterwards.

        Args:
            closing_mm: Way of each finger towards the object [mm].
            rising_mm: Way of both fingers upwards [mm].
            dt_s: Time that it takes [s].

        Raises:
            ConfigError: The fingers would leave the workspace; nothing has changed.
            ConvergenceError: No valid equilibrium was found; nothing has changed.
        """
        before, last = self.live.now(), self.state
        moved = replace(last, gap_mm=last.gap_mm - closing_mm, finger_mm=last.finger_mm + rising_mm)
        try:
            placed, speed = self._settle(before, moved, rising_mm, dt_s)
        except BaseException:
            self.live.go_back(before)
            raise
        self.state = LiftState(
            gap_mm=moved.gap_mm,
            finger_mm=moved.finger_mm,
            object_mm=placed,
            falling_mm_s=speed,
            carried_n=self._carried_n(),
            normal_n=float(self.live.deformation.force_n[2]),
            slip_share=self.live.slip_share,
            slip_mm=self.live.slid_mm - before.slid_mm,
            has_dropped=placed == 0 < last.object_mm and last.object_mm + min(rising_mm, 0.0) > 0,
        )
        return self.state

    def _settle(self, before: Moment, moved: LiftState, rising_mm: float, dt_s: float) -> tuple[float, float]:
        """Height of the object [mm] and the speed at which it falls [mm/s]; the sensor is left there."""
        tried: dict[float, tuple[float, Moment]] = {}

        def excess(height_mm: float) -> float:
            """Friction less weight with the object at a height [N], 0 where they balance; the sensor is left there."""
            if height_mm not in tried:
                self.live.go_back(before)
                self.live.move_to(gap_mm=moved.gap_mm, y_mm=self._y_mm + height_mm - moved.finger_mm)
                difference = self._carried_n() - self.weight_n
                is_balanced = abs(difference) <= BALANCE_SHARE * self.weight_n
                tried[height_mm] = (0.0 if is_balanced else difference, self.live.now())
            value, moment = tried[height_mm]
            self.live.go_back(moment)
            return value

        # A standing object stays, a hanging one goes along, and neither goes below the table.
        start = max(0.0, moved.object_mm + rising_mm) if moved.object_mm > 0 else 0.0
        at_start = excess(start)
        if at_start > 0:
            return self._risen(excess, start, max(rising_mm, FIRST_RISE_MM)), 0.0
        if at_start == 0 or start == 0:
            return start, 0.0
        pull = GRAVITY_MM_S2 * min(1.0, -at_start / self.weight_n)
        low = max(0.0, start - moved.falling_mm_s * dt_s - pull * dt_s**2 / 2)
        if excess(low) > 0:
            return self._between(excess, low, start), 0.0
        return low, 0.0 if low == 0 or excess(low) == 0 else moved.falling_mm_s + pull * dt_s

    def _risen(self, excess: Callable[[float], float], low: float, rise: float) -> float:
        while excess(low + rise) > 0 and rise < MOST_RISE_MM:
            rise *= 2
        return self._between(excess, low, low + rise)

    @staticmethod
    def _between(excess: Callable[[float], float], low: float, high: float) -> float:
        if excess(high) >= 0:
            return high
        height = float(brentq(excess, low, high, xtol=FINEST_MM))
        excess(height)
        return height

    def _carried_n(self) -> float:
        return -FINGERS * float(self.live.deformation.force_n[1])
