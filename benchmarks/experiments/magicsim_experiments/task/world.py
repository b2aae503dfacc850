"""Gripper, carriage, item and hands: what a command does to them, frame by frame. No image is looked at here."""

import math
from dataclasses import dataclass, replace
from typing import Literal

from magicsim.detectors.grasp import GraspStage
from magicsim.errors import ConfigError
from magicsim.robot.fingers import ObjectPlace, half_extents_mm
from magicsim.robot.grip.linkage import Linkage
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig
from magicsim_experiments.task.hand import WAY_MM, hand_mesh, hand_pose
from magicsim_experiments.task.settings import GraspConfig, Item
from magicsim_experiments.task.story import Since, Story

FARTHEST_MM = 60.0
"""Widest gap between an item and a finger [mm]."""
BEYOND_MM = 60.0
"""From where, in front of the fingertips, a hand brings an item [mm]."""
SLIDE_MM = 4.0
"""Room in the workspace for an item that is held and slips [mm]."""
DEEPEST_MM, TILT_DEG, TWIST_DEG = 2.0, 10.0, 25.0
PATIENCE_S = 3.0
"""How long a hand offers an item that nobody takes [s]."""
ROUNDING_MM = 1e-6
"""Difference of widths or places that counts as none [mm]."""
FINE_MM, FINE_STEP_MM = 0.6, 0.15
"""Room on each side below which fingers close by less in a frame [mm]: they slow down before they press."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """Motion of the next frame."""

    fingers: Literal["close", "open", "stay"]
    carriage: Literal["to_b", "to_a", "stay"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """Where it is."""

    place_mm: float = 0.0
    speed_mm_s: float = 0.0
    acceleration_mm_s2: float = 0.0
    """In the last step."""


def driven(now: Carriage, target_mm: float, *, dt_s: float, most_mm_s: float, most_mm_s2: float) -> Carriage:
    """The carriage after a step towards a place: it speeds up, and slows down in time to stop there."""
    left, brake = target_mm - now.place_mm, most_mm_s2 * dt_s
    # A speed that falls by one brake in each of the next n steps stops exactly at the target.
    steps = math.floor((math.sqrt(1 + 8 * abs(left) / (brake * dt_s)) - 1) / 2)
    stopping = (abs(left) / dt_s + brake * steps * (steps + 1) / 2) / (steps + 1)
    wanted = math.copysign(min(most_mm_s, stopping), left)
    change = min(max(wanted - now.speed_mm_s, -brake), brake)
    speed = now.speed_mm_s + change
    place = now.place_mm + speed * dt_s
    return Carriage(
        place_mm=target_mm if abs(place - target_mm) < ROUNDING_MM else place,
        speed_mm_s=speed,
        acceleration_mm_s2=change / dt_s,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Happened:
    """What became true in one step."""

    event: str = ""
    """`appears`, `offered`, `let_go`, `pulled`, `dropped`, `delivered`, `withdrawn`, or nothing."""
    light: bool = False


class World:
    """One episode's world, moved by `step`."""

    def __init__(self, gripper: Gripper, item: Item, story: Story, config: GraspConfig) -> None:
        """Fingers open at A, nothing between them."""
        self.gripper, self.item, self.story, self.config = gripper, item, story, config
        self.carriage = Carriage()
        self.open_mm = gripper.touching_width_mm + 2 * config.open_gap_mm
        self._dt_s = 1 / config.frames_per_second
        self._frame, self._transport, self._offered = 0, -1, -1
        self._since = {Since.BEGINNING: 0}
        self._hand_y_mm, self._is_delivered, self._has_come = BEYOND_MM, False, False
        self._pull_n, self._has_stalled, self._let_go = 0.0, False, 0
        gripper.close(self.open_mm, place=ObjectPlace())
        gripper.remove_object()

    @property
    def is_open(self) -> bool:
        """Whether the fingers are as far open as at the start."""
        return self.gripper.width_mm >= self.open_mm - ROUNDING_MM

    @property
    def has_item(self) -> bool:
        """Whether the item is between the fingers or before them."""
        return not self.gripper.outcome.is_empty

    @property
    def is_held(self) -> bool:
        """Whether the fingers alone hold it."""
        return self.gripper.outcome in (Hold.HELD, Hold.SLIPPED)

    @property
    def is_at_b(self) -> bool:
        """Whether the carriage stands at B."""
        return self.carriage.place_mm == self.config.distance_mm

    @property
    def hand_mm(self) -> float | None:
        """How far in front of where it holds the item a hand is [mm]; None while none is near."""
        if self.gripper.outcome is Hold.PLACED:
            return None if self._is_delivered else 0.0
        if not self.is_held:
            return None
        if self._pull_n > 0:
            return 0.0
        frames = [self._frame - self._let_go]
        if self.story.pull is not None and self._transport >= 0:
            frames.append(self.story.pull - self._transport)
        away_mm = min(frames) * self.story.speed_mm_s * self._dt_s
        return away_mm if away_mm < WAY_MM else None

    def step(self, stage: GraspStage, asked: Command) -> Happened:
        """Lets one frame's time pass; a hand sees the stage in what the gripper does."""
        frame, self._frame = self._frame, self._frame + 1
        self._transport = self._transport + 1 if stage is GraspStage.TRANSPORTING else -1
        if self._is_delivered and self.is_open and self.has_item:
            self.gripper.remove_object()  # it stays on its tray at B
        event = "" if self._is_delivered else self._hands(stage, frame)
        self._drive(asked)
        event = self._move_fingers(asked) or event
        away_mm = self.hand_mm
        if self.config.hand:
            self.gripper.accompany(None if away_mm is None else hand_pose(self.gripper.place, away_mm))
        return Happened(event=event, light=self._shine(frame, asked))

    def deliver(self) -> str:
        """A tray at B takes the item: it is placed, no longer held. Gives the event, nothing of empty fingers."""
        if not self.is_held:
            return ""
        self.gripper.close(self.gripper.width_mm, place=self.gripper.place)
        self._is_delivered = True
        return "delivered"

    def _hands(self, stage: GraspStage, frame: int) -> str:
        """Brings the item, goes along until it feels a firm grip, lets go, pulls, takes back what nobody takes."""
        story, gripper = self.story, self.gripper
        if not self._has_come and frame >= story.appears and self._has_room:
            self._has_come = True
            self._place()
            return "appears"
        if gripper.outcome is Hold.PLACED and self._hand_y_mm > 0:
            return self._bring(frame)
        if gripper.outcome is Hold.PLACED and stage is GraspStage.TRANSPORTING and self._has_stalled:
            self._let_go = frame + 1
            lost = gripper.hold(load=self._load()) is Hold.DROPPED
            return "dropped" if lost else "let_go"
        if self.is_held and story.pull is not None and self._transport >= story.pull:
            self._pull_n += self.config.pull_n_s * self._dt_s
            if gripper.hold(load=self._load()) is Hold.DROPPED:
                return "pulled"
        elif gripper.outcome is Hold.PLACED and stage is GraspStage.WAITING and self._is_tired(frame):
            gripper.remove_object()
            return "withdrawn"
        return ""

    def _bring(self, frame: int) -> str:
        """Brings the item nearer, or takes it back where the fingers have closed meanwhile."""
        if not self._has_room:
            self.gripper.remove_object()
            return "withdrawn"
        self._hand_y_mm = max(0.0, self._hand_y_mm - self.story.speed_mm_s * self._dt_s)
        self._place()
        if self._hand_y_mm > 0:
            return ""
        self._offered = frame
        return "offered"

    def _is_tired(self, frame: int) -> bool:
        return self._offered >= 0 and frame - self._offered > PATIENCE_S * self.config.frames_per_second

    @property
    def _has_room(self) -> bool:
        """Whether an item goes between the fingers."""
        return self.gripper.width_mm > self.gripper.touching_width_mm + ROUNDING_MM

    def _place(self) -> None:
        story, half = self.story, self.gripper.width_mm / 2
        up, down = half_extents_mm(self.item.object)
        # A hand on its way keeps clear of fingers that have begun to close.
        wanted = 0.0 if self.is_open else self.config.close_mm_s * self._dt_s + FINE_STEP_MM
        clear = min(wanted, half - (up + down) / 2)
        z_mm = max(min(self.open_mm / 2 - story.near_mm, half - clear) - up, down + clear - half)
        y_mm = story.y_mm + self._hand_y_mm + self._ahead_mm()
        place = ObjectPlace(y_mm=y_mm, z_mm=z_mm, twist_deg=story.twist_deg)
        self.gripper.close(self.gripper.width_mm, place=place)

    def _ahead_mm(self) -> float:
        """How far before the fingertips a hand offers the item: they come along their arcs while they close [mm]."""
        linkage, gripper = self.gripper.linkage, self.gripper
        return linkage.along_mm(linkage.angle_deg(gripper.touching_width_mm)) - linkage.along_mm(gripper.angle_deg)

    def _load(self) -> Load:
        """Weight, what the carriage's acceleration adds, and the pull of a hand."""
        turn = math.radians(self.story.pull_deg)
        inertia = -self.item.mass_g * 1e-6 * self.carriage.acceleration_mm_s2  # kg m/s2
        force = (inertia + self._pull_n * math.cos(turn), self._pull_n * math.sin(turn), 0.0)
        return Load.of_mass(self.item.mass_g, force_n=force)

    def _drive(self, asked: Command) -> None:
        config, before = self.config, self.carriage
        targets = {"to_b": config.distance_mm, "to_a": 0.0, "stay": before.place_mm}
        self.carriage = driven(
            before, targets[asked.carriage], dt_s=self._dt_s, most_mm_s=config.carriage_mm_s,
            most_mm_s2=config.carriage_mm_s2,
        )  # fmt: skip

    def _move_fingers(self, asked: Command) -> str:
        """Closes until the motors stall, or opens; what is held answers to the carriage's acceleration."""
        gripper, config = self.gripper, self.config
        width = gripper.width_mm
        if asked.fingers == "close" and not self._has_stalled:
            near = self.has_item and width < gripper.touching_width_mm + 2 * FINE_MM
            width -= 2 * (FINE_STEP_MM if near else config.close_mm_s * self._dt_s)
            if self.has_item and (not near or self._hand_y_mm > 0):
                # Fingers press at their slow speed alone, and nothing before it is between them.
                width = max(width, gripper.touching_width_mm)
        elif asked.fingers == "open":
            width, self._has_stalled = min(width + 2 * config.open_mm_s * self._dt_s, self.open_mm), False
        least = gripper.linkage.width_mm(gripper.linkage.least_deg)
        if not self.has_item:
            width = max(width, least, self.open_mm - 4 * config.open_gap_mm)
        held = self.is_held
        if width != gripper.width_mm:
            # A hand gives way along the closing axis.
            gripper.turn_to(gripper.linkage.angle_deg(max(width, least)), dt_s=self._dt_s, floats=True)
            self._has_stalled = gripper.truth().is_stalled
        elif held and gripper.truth().load != self._load():
            gripper.hold(load=self._load())
        if not held or gripper.outcome is not Hold.DROPPED:
            return ""
        return "pulled" if self._pull_n > 0 else "dropped"

    def _shine(self, frame: int, asked: Command) -> bool:
        """Turns the story's flashlights on and off, each by what has happened."""
        begun = {
            Since.OFFERED: self._offered >= 0, Since.CLOSING: asked.fingers == "close", Since.PULL: self._pull_n > 0,
            Since.DELIVERED: self._is_delivered,
        }  # fmt: skip
        for since in (since for since, has_begun in begun.items() if has_begun):
            self._since.setdefault(since, frame)
        passed = {since: frame - first for since, first in self._since.items()}
        passed[Since.TRANSPORT] = self._transport  # -1 outside of it: such a light ends with the transport
        for light in self.story.lights:
            if light.shines(passed.get(light.since, -1)):
                self.gripper.upper.shine(x_mm=light.x_mm)
                return True
        self.gripper.upper.shine(on=False)
        return False


def check_room_for(item: Item, name: str, config: GraspConfig) -> None:
    """Refuses an item that open fingers have no room for, before they are built."""
    thick = sum(half_extents_mm(item.object))
    opening = Linkage().width_mm(Linkage().most_deg)
    if thick >= opening:
        msg = f"items: '{name}' is not allowed: {thick:.4g} mm thick, and the fingers open to {opening:.4g} mm"
        raise ConfigError(msg)
    most = min((opening - thick) / 2, (FARTHEST_MM + config.near_mm[0]) / 2)
    if config.open_gap_mm > most:
        msg = f"open_gap_mm = {config.open_gap_mm:g} is not allowed with item '{name}': must be at most {most:.4g}"
        raise ConfigError(msg)


def build_gripper(scene: SceneConfig, config: GraspConfig) -> Gripper:
    """The gripper of the task, its motors as strong as the task says."""
    space = Workspace(
        x_mm=(-SLIDE_MM, SLIDE_MM), y_mm=(-SLIDE_MM, SLIDE_MM), twist_deg=(-TWIST_DEG, TWIST_DEG),
        tilt_x_deg=(-TILT_DEG, TILT_DEG), tilt_y_deg=(-TILT_DEG, TILT_DEG), gap_mm=(-DEEPEST_MM, FARTHEST_MM),
        beyond_mm=BEYOND_MM + Linkage().link_mm,
    )  # fmt: skip
    return Gripper(
        scene, workspace=space, linkage=replace(Linkage(), force_limit_n=config.grip_n), quality=config.quality,
        companion=hand_mesh(scene.object) if config.hand and scene.object is not None else None,
    )  # fmt: skip
