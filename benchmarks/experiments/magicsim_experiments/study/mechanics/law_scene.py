"""Presses, shears and twists of one object, with the displacement of the grid and the images: pieces of a study."""

import io
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Mask
from magicsim.config.models import validate
from magicsim.deform.lattice.structure import build_lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import OutputSettings, RenderSettings, SceneConfig
from magicsim.simulation.stream import simulate

MOVED_SHARE = 0.2
"""Part of the largest displacement from which a place counts as moved."""


def extent_mm(places_mm: Array, moved_mm: Array, *, least_mm: float) -> float:
    """Radius of the circle whose area is that of the places that moved by so much at least [mm].

    Args:
        places_mm: Evenly spaced, shape (places, 2) [mm].
        moved_mm: Length of each displacement, shape (places,) [mm].
    """
    axes = [np.unique(np.round(places_mm[:, axis], 6)) for axis in (0, 1)]
    area = float(np.prod([np.ptp(axis) / max(len(axis) - 1, 1) for axis in axes]))
    return float(np.sqrt((moved_mm >= least_mm).sum() * area / np.pi))


def direction_deg(moved: Array) -> float:
    """Direction of the sum of displacements of shape (places, 2), from x towards y [degrees]."""
    x, y = moved.sum(0)
    return float(np.degrees(np.arctan2(y, x)))


def turn_deg(places: Array, moved: Array) -> float:
    """Turn about the origin that is nearest to displacements in the mean square, from x towards y [degrees].

    Places and displacements have one unit and the shape (places, 2).
    """
    x, y = places.T
    return float(np.degrees((x * moved[:, 1] - y * moved[:, 0]).sum() / max((x * x + y * y).sum(), 1e-12)))


def moved_places(moved: Array) -> Mask:
    """Which places moved by at least `MOVED_SHARE` of the largest displacement, shape (places,)."""
    length = np.linalg.norm(moved, axis=1)
    return np.asarray(length >= MOVED_SHARE * length.max())


def angle_between_deg(found: float, true: float) -> float:
    """Found less true angle, in -180 to 180 [degrees]."""
    return (found - true + 180.0) % 360.0 - 180.0


def optical_flow_px(before: npt.NDArray[np.uint8], after: npt.NDArray[np.uint8]) -> Array:
    """Dense inverse search from one RGB image to another, shape (rows, columns, 2): flow to the right and down [px]."""
    grey = [cv2.cvtColor(each, cv2.COLOR_RGB2GRAY) for each in (before, after)]
    search = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)  # type: ignore[attr-defined]
    return np.asarray(search.calc(grey[0], grey[1], None), np.float64)


LIFTED_MM = 1.0
"""Gap between two touches [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """One touch: a press, and what is done under contact."""

    depth_mm: float
    shear_mm: float = 0.0
    direction_deg: float = 0.0
    """Direction of the shear, from x towards y [degrees]."""
    twist_deg: float = 0.0

    def keyframes(self) -> list[dict[str, float]]:
        """The press, what follows under contact if anything does, and the object away from the face."""
        pressed = {"gap_mm": -self.depth_mm, "x_mm": 0.0, "y_mm": 0.0, "twist_deg": 0.0}
        angle = np.radians(self.direction_deg)
        after = pressed | {
            "x_mm": float(self.shear_mm * np.cos(angle)),
            "y_mm": float(self.shear_mm * np.sin(angle)),
            "twist_deg": self.twist_deg,
        }
        return [pressed, *([after] if after != pressed else []), pressed | {"gap_mm": LIFTED_MM}]


@dataclass(frozen=True, slots=True, kw_only=True)
class LawTask:
    """A series of touches of one sensor."""

    design: ElastomerDesign
    rig: Rig
    object: ObjectBase
    friction: float
    render: RenderSettings
    touches: tuple[Touch, ...]
    seed: int


def touch_fields(task: LawTask) -> bytes:
    """Fields of every touch as an `.npz`: what its press and its end did to the grid and to the image.

    Holds `places_mm` (nodes, 2) of the uppermost plane of the printed grid, and with one entry a touch `pressed_mm` and
    `moved_mm` (nodes, 3), `pressed_image` and `image` (rows, columns, 3), `mask` (rows, columns), `force_n` and
    `torque_nmm`; and `untouched` (rows, columns, 3).
    """
    poses = [pose for touch in task.touches for pose in touch.keyframes()]
    scene = validate(
        SceneConfig,
        {
            "schema_version": 1, "design": task.design, "rig": task.rig, "object": task.object.model_dump(),
            "references": 1, "seed": task.seed, "contact": {"friction": task.friction}, "render": task.render,
            "output": OutputSettings(preview=False, report=False),
            "keyframes": [{"frame": number, **pose} for number, pose in enumerate(poses)],
        },
        source="touches",
    )  # fmt: skip
    frames = simulate(scene).frames
    lattice = build_lattice(task.design)
    plane = lattice.planes_mm[2][np.searchsorted(lattice.planes_mm[2], task.design.skin_mm - 1e-6)]
    nodes = np.abs(lattice.nodes_mm[:, 2] - plane) < 1e-6  # noqa: PLR2004 -- rounding
    start, pressed, ended = 1, [], []
    for touch in task.touches:
        count = len(touch.keyframes())
        pressed.append(frames[start])
        ended.append(frames[start + count - 2])
        start += count
    content = io.BytesIO()
    np.savez_compressed(
        content, places_mm=lattice.nodes_mm[nodes, :2], untouched=frames[0].image,
        pressed_mm=np.stack([frame.displacements_mm[nodes] for frame in pressed]),
        moved_mm=np.stack([frame.displacements_mm[nodes] for frame in ended]),
        pressed_image=np.stack([frame.image for frame in pressed]), image=np.stack([frame.image for frame in ended]),
        mask=np.stack([frame.contact_mask for frame in ended]),
        force_n=np.array([frame.truth.force_n for frame in ended]),
        torque_nmm=np.array([frame.truth.torque_nmm for frame in ended]),
    )  # fmt: skip
    return content.getvalue()
