"""What a base does to a plug: an elastic foundation with Coulomb friction against the motion, and the jack's springs.

Every element of the plug's surface that lies below the base's, by d, and faces it is pushed out with the pressure
`stiffness_n_mm3` d along the base's normal, on its area as the base sees it (an elastic foundation, Johnson, Contact
Mechanics, 1985, 4.3). Plug and base are far stiffer than the skin that holds the plug, so the stiffness has to be high;
it is assumed. Friction is kinetic, against the carriage's motion. The contacts of the jack resist a pin in the hole by
a force along the axis that comes with its depth.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field
from scipy.spatial.transform import Rotation

from magicsim.arrays import Array
from magicsim.config.models import Config
from magicsim.geometry.objects.plain import PlugObject
from magicsim.geometry.pose import Pose
from magicsim.robot.grip.load import Load
from magicsim_experiments.task.settings import Positive, in_order

FAR_MM = 1e4
"""How far the base reaches [mm]."""
TINY = 1e-12


class Jack(Config):
    """The hole in the base; all numbers are assumed."""

    radius_mm: Annotated[float, Field(ge=0.05, le=100)] = 2.6
    """Radius [mm]: 0.1 mm more than the default plug's pin."""
    chamfer_mm: Annotated[float, Field(ge=0, le=50)] = 0.5
    """Chamfer of the mouth, at 45 degrees [mm]."""
    depth_mm: Annotated[float, Field(ge=0.1, le=200)] = 12.0
    """Depth [mm]."""

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Signed distance to the base, negative inside of it, and the outward normal, exact.

        Args:
            points: In the jack's frame, shape (points, 3) [mm].

        Returns:
            Shapes (points,) [mm] and (points, 3).
        """
        radial = np.hypot(points[:, 0], points[:, 2])
        outward = np.stack([points[:, 0], points[:, 2]], 1) / np.maximum(radial, TINY)[:, None]
        places = np.stack([radial, points[:, 1]], 1)
        radius, mouth, depth = self.radius_mm, self.radius_mm + self.chamfer_mm, self.depth_mm
        # The base's surface in the half plane (radial, axial), from far away to the hole's bottom.
        corners = np.array([[FAR_MM, 0], [mouth, 0], [radius, self.chamfer_mm], [radius, depth], [0, depth]], float)
        best, foot = np.full(len(points), np.inf), np.zeros_like(places)
        normal = np.zeros_like(places)
        for first, last in pairwise(corners):
            way = last - first
            length = float(np.linalg.norm(way))
            if length < TINY:
                continue
            share = np.clip((places - first) @ way / length**2, 0, 1)
            nearest = first + share[:, None] * way
            away = np.linalg.norm(places - nearest, axis=1)
            closer = away < best
            best[closer], foot[closer] = away[closer], nearest[closer]
            normal[closer] = np.array([way[1], -way[0]]) / length
        height = np.where(places[:, 0] < radius, depth, np.clip(mouth - places[:, 0], 0.0, None))
        inside = places[:, 1] > height
        signed = np.where(inside, -best, best)
        offset = (places - foot) * np.where(inside, -1.0, 1.0)[:, None]
        is_on = best < TINY
        turned = np.where(is_on[:, None], normal, offset / np.maximum(best, TINY)[:, None])
        full = np.stack([turned[:, 0] * outward[:, 0], turned[:, 1], turned[:, 0] * outward[:, 1]], 1)
        return signed, full


AROUND, ACROSS, ALONG, RIM = 32, 8, 24, 4
"""Elements around the axis, from the axis outwards on a flat end, along the pin, and across its rounded rim."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elements:
    """Points on the plug's surface in its own frame."""

    points_mm: Array
    """Shape (elements, 3) [mm]."""
    normals: Array
    """Outward, shape (elements, 3)."""
    area_mm2: Array
    """Shape (elements,) [mm2]."""


def plug_elements(plug: PlugObject) -> Elements:
    """The elements of a plug whose handle is centred on the origin and whose pin points along +y."""
    solid = plug.solid()
    radius, rim = plug.pin_radius_mm, solid.pin.edge_radius_mm
    shoulder, tip = plug.length_mm / 2, plug.length_mm / 2 + plug.pin_length_mm
    rings: list[tuple[float, float, float, float, float]] = []  # radial, axial, normal along both, width
    rings += [(r, tip, 0.0, 1.0, w) for r, w in _steps(0.0, radius - rim, ACROSS)]
    for angle, width in _steps(0.0, np.pi / 2, RIM):
        across, along = float(np.cos(angle)), float(np.sin(angle))
        rings.append((radius - rim + rim * across, tip - rim + rim * along, across, along, rim * width))
    rings += [(radius, y, 1.0, 0.0, w) for y, w in _steps(shoulder, tip - rim, ALONG)]
    rings += [(r, shoulder, 0.0, 1.0, w) for r, w in _steps(radius, plug.radius_mm - plug.edge_radius_mm, ACROSS)]
    angles = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    cosine, sine = np.cos(angles), np.sin(angles)
    points, normals, areas = [], [], []
    for radial, axial, across, along, width in rings:
        points.append(np.stack([radial * cosine, np.full(AROUND, axial), radial * sine], 1))
        normals.append(np.stack([across * cosine, np.full(AROUND, along), across * sine], 1))
        areas.append(np.full(AROUND, 2 * np.pi * radial * width / AROUND))
    return Elements(points_mm=np.concatenate(points), normals=np.concatenate(normals), area_mm2=np.concatenate(areas))


def _steps(low: float, high: float, count: int) -> list[tuple[float, float]]:
    """Middles and widths of equal steps."""
    width = (high - low) / count
    return [(low + (step + 0.5) * width, width) for step in range(count)]


FORWARD = 1.0
AXES = 3
STEP_MM, STEP_RAD = 0.02, 0.002
"""Motions over which the stiffness is taken: it begins with contact."""


class Contact(Config):
    """Contact between plug and base; all numbers are assumed."""

    stiffness_n_mm3: Annotated[float, Field(ge=0.1, le=100)] = 5.0
    """Pressure by depth [N/mm3]."""
    friction: Annotated[float, Field(ge=0, le=2)] = 0.2
    """Coulomb's coefficient between plastic and plastic."""
    spring_n: Annotated[float, Field(ge=0, le=100)] = 1.5
    """Resistance of the jack's contacts to a pin in the hole [N]."""
    spring_mm: Annotated[tuple[Positive, Positive], AfterValidator(in_order)] = (2.0, 4.0)
    """Depths of the pin at which that begins, and is there in full [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MetLoad(Load):
    """Weight of a plug, and the wrench of a base on it wherever it is."""

    elements: Elements | None = None
    """The plug's surface; None is a load without a base."""
    jack: Jack = field(default_factory=Jack)
    base: Pose | None = None
    """From the jack's frame to the gripper's; None is out of reach."""
    contact: Contact = field(default_factory=Contact)
    way: float = 0.0
    """Sense of the plug's motion along the jack's axis: 1 into the hole, -1 out of it, 0 at rest."""

    def wrench(self, pose: Pose) -> Array:
        """Wrench of weight, outer force and base, shape (6,); see `Load.wrench`."""
        return Load.wrench(self, pose) + self.met(pose)

    def met(self, pose: Pose) -> Array:
        """Force [N] and torque about the plug's origin [N mm] of the base alone, in the gripper's frame, shape (6,)."""
        if self.elements is None or self.base is None:
            return np.zeros(6)
        points = pose.to_sensor(self.elements.points_mm)
        local = self.base.to_object(points)
        depth, normal = self.jack.distance(local)
        outward = self.elements.normals @ (self.base.rotation.T @ pose.rotation).T
        facing = np.maximum(-np.einsum("ei,ei->e", outward, normal), 0.0)
        size = self.contact.stiffness_n_mm3 * np.maximum(-depth, 0.0) * facing * self.elements.area_mm2
        force = size[:, None] * normal
        if self.way != 0:
            sliding = np.array([0.0, 1.0, 0.0]) - normal * normal[:, 1:2]
            force -= self.way * self.contact.friction * size[:, None] * sliding
        force = force @ self.base.rotation.T
        spring = self.base.rotation @ self._spring(local)
        tip = pose.rotation @ np.array([0.0, float(self.elements.points_mm[:, 1].max()), 0.0])
        torque = np.cross(points - pose.position_mm, force).sum(0)
        return np.concatenate([force.sum(0) + spring, torque + np.cross(tip, spring)])

    def stiffness(self, pose: Pose) -> Array:
        """How the base's wrench falls with the plug's motion, shape (6, 6), by differences; see `Load.stiffness`."""
        found = np.zeros((6, 6))
        if self.elements is None or self.base is None:
            return found
        for number, unit in enumerate(np.eye(6)):
            step = STEP_MM * unit if number < AXES else STEP_RAD * unit
            above, below = (
                Pose(
                    position_mm=pose.position_mm + sign * step[:AXES],
                    rotation=Rotation.from_rotvec(sign * step[AXES:]).as_matrix() @ pose.rotation,
                )
                for sign in (1, -1)
            )
            found[:, number] = (self.met(below) - self.met(above)) / (2 * step[number])
        return found

    def _spring(self, local: Array) -> Array:
        """Force of the jack's contacts along its axis, shape (3,) [N]; none outside of the hole."""
        deepest = local[int(local[:, 1].argmax())]
        if np.hypot(deepest[0], deepest[2]) > self.jack.radius_mm + self.jack.chamfer_mm:
            return np.zeros(3)
        low, high = self.contact.spring_mm
        share = float(np.clip((deepest[1] - low) / (high - low), 0, 1))
        return np.array([0.0, -self.way * self.contact.spring_n * share, 0.0])
