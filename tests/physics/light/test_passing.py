"""Something that passes in the room: the frames of a still room with it in its image, and nothing of earlier frames."""

import numpy as np
import pytest
from PIL import Image

from magicsim.scenes.room import Passing, room_radiance, solid_angles
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor

ROWS = 256
AMBIENT = 0.3
HAND = {"distance_mm": 300.0, "size_mm": (400.0, 300.0), "rise_mm": 60.0, "reflectance": (0.05, 0.3, 0.9)}
PLACE_MM = 80.0
SMALL = (
    "rig=digit-rgb", "rig.camera.columns=48", "rig.camera.rows=56", "rig.camera.field_mm=7",
    "render.anchor_particles=150000",
    "design.footprint_mm=[8,9]", "render.particles=30000", "render.samples=16", "render.anchor_samples=32",
    "object.radius_mm=3", "seed=5", "design.lattice.cells_across=0",
)  # fmt: skip


QUICK = (
    "render.anchor_particles=4000", "render.particles=2000", "render.samples=1", "render.anchor_samples=2",
    "rig.camera.columns=12", "rig.camera.rows=14",
)  # fmt: skip
"""Where frames are the same to the last bit, whatever their noise."""


def directions():
    """Unit vectors of an image's pixels, shape (rows, columns, 3)."""
    row, column = np.mgrid[:ROWS, : 2 * ROWS]
    up, turn = np.pi * (0.5 - (row + 0.5) / ROWS), 2 * np.pi * ((column + 0.5) / (2 * ROWS) - 0.5)
    return np.stack([np.cos(up) * np.sin(turn), np.sin(up), -np.cos(up) * np.cos(turn)], -1)


def covered(passing, x_mm):
    """Share of each pixel that something hides, from the definition of `Passing`."""
    to = directions()
    far = passing.distance_mm / np.maximum(-to[..., 2], 1e-6)
    shares = [
        (far * to[..., 0] - x_mm) / (passing.size_mm[0] / 2),
        (far * to[..., 1] - passing.rise_mm) / (passing.size_mm[1] / 2),
    ]
    t = [np.clip((1 - np.abs(each)) / 0.2, 0, 1) for each in shares]
    faded = [each**2 * (3 - 2 * each) for each in t]
    return np.where(to[..., 2] < 0, faded[0] * faded[1], 0)[..., None]


def written(path, radiance):
    """An image of a room, and the mean radiance that it stands for."""
    mean = (radiance * solid_angles(ROWS)[:, None, None]).sum(0).mean(0)
    linear = radiance / radiance.max()
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    Image.fromarray(np.rint(255 * coded).astype(np.uint8)).save(path)
    return mean


@pytest.fixture
def rooms(tmp_path):
    """Settings of a still room, and of one with the hand in its image."""
    to = directions()
    wall = np.broadcast_to([0.8, 1.0, 1.1], to.shape) * (1 + 0.5 * to[..., :1]) + 3 * (to[..., 1:2] > 0.8)
    first = written(tmp_path / "still.png", wall)
    still = room_radiance(str(tmp_path / "still.png")) * AMBIENT
    passing = Passing(**HAND)
    share = covered(passing, PLACE_MM)
    mean = written(tmp_path / "hand.png", still * (1 - share) + share * np.array(passing.reflectance) * AMBIENT)
    assert (first > 0).all()
    return (
        (f"rig.room='{tmp_path / 'still.png'}'", f"rig.ambient=[{AMBIENT},{AMBIENT},{AMBIENT}]"),
        (f"rig.room='{tmp_path / 'hand.png'}'", "rig.ambient=[" + ",".join(f"{each:.9g}" for each in mean) + "]"),
    )


def sensor_of(*settings):
    return Sensor.for_scene(load_scene("near", [*SMALL, *settings]))


def table(passing):
    return (
        "rig.passing={"
        + ",".join(f"{key}={list(v) if isinstance(v, tuple) else v}" for key, v in passing.items())
        + "}"
    )


def state(gap_mm, passing_mm):
    return FrameState(
        gap_mm=gap_mm, x_mm=0.0, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0, passing_mm=passing_mm
    )


def blocks(image):
    return image[:56, :48].reshape(7, 8, 6, 8, 3).mean((1, 3))


@pytest.mark.parametrize(
    "gap_mm", [pytest.param(None, marks=pytest.mark.slow), pytest.param(0.5, marks=pytest.mark.slow), -0.4]
)
def test_frames_are_those_of_a_still_room_with_it_in_the_image(rooms, gap_mm):
    moving, still = sensor_of(*rooms[0], table(HAND)), sensor_of(*rooms[1])
    here, away = state(gap_mm, PLACE_MM), state(gap_mm, None)
    deformation = moving.deform(away, moving.rest) if gap_mm is not None and gap_mm < 0 else moving.rest
    ours, without = (moving.radiance(each, deformation) for each in (here, away))
    theirs = still.radiance(away, deformation)
    change = theirs.mean((0, 1)) - without.mean((0, 1))
    assert (np.abs(change) > 0.01 * without.mean((0, 1))).all(), "too little changes to tell anything"
    np.testing.assert_allclose(ours.mean((0, 1)), theirs.mean((0, 1)), rtol=0.004)
    off = np.abs(blocks(ours) - blocks(theirs)) / blocks(theirs).mean()
    assert off.mean() < 0.01


def test_a_frame_does_not_depend_on_those_before(rooms):
    first, later = (sensor_of(*rooms[0], table(HAND), *QUICK) for _ in range(2))
    for gap_mm, place_mm in ((0.5, -200.0), (None, 40.0), (0.5, 40.0)):
        seen = first.radiance(state(gap_mm, place_mm), first.rest)
    np.testing.assert_array_equal(seen, later.radiance(state(0.5, 40.0), later.rest))


def test_it_moves_the_image_smoothly(rooms):
    sensor = sensor_of(*rooms[0], table(HAND))
    still, *moved = (sensor.radiance(state(None, place), sensor.rest) for place in (None, 0.0, 2.0, 4.0))
    change = [blocks(each) - blocks(still) for each in moved]
    bend = np.abs(change[0] - 2 * change[1] + change[2]).mean()
    assert bend < 0.02 * np.abs(change[1]).mean()
