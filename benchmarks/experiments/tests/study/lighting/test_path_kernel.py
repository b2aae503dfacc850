import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.scenes.rig import load_rig
from magicsim_experiments.study.lighting.path_kernel import follow_paths, fresnel
from magicsim_experiments.study.lighting.wall_modes import ROOM, wall_modes

N_BODY = 1.5
BLOCK = {
    "low": np.array([-12.0, -16.0, 0.0]), "high": np.array([12.0, 16.0, 8.0]), "origin": np.array([-11.0, -15.0, 1.0]),
    "pitch": np.ones(3), "cell": np.full(3, 0.8), "counts": np.array([22, 30, 5]), "anisotropy": np.zeros(2),
}  # fmt: skip
NO_STRIPS = np.zeros((0, 7))


def followed(
    count=20_000, *, direction=(0.0, 0.0, -1.0), infill=N_BODY, scattering=0.0, absorption=0.0, strips=NO_STRIPS
):
    way = np.array(direction) / np.linalg.norm(direction)
    ways = np.zeros((count, 2, 3))
    ways[:, 0] = [0.13, 0.21, 8.0]
    ways[:, 1] = way
    found, events, lost = follow_paths(
        ways, np.ones(count), 1, indices=np.array([N_BODY, infill]), scattering=np.full(2, float(scattering)),
        absorption=np.full(2, float(absorption)), strips=strips, **BLOCK,
    )  # fmt: skip
    return found / count, events / count, lost


def test_fresnel_at_normal_incidence_at_brewsters_angle_and_beyond_the_critical_one():
    assert fresnel(1.0, 1.0, 1.5) == pytest.approx(0.04)
    brewster = np.arctan(1.5)
    across = ((np.cos(brewster) - 1.5 * np.sqrt(1 - (np.sin(brewster) / 1.5) ** 2))
              / (np.cos(brewster) + 1.5 * np.sqrt(1 - (np.sin(brewster) / 1.5) ** 2))) ** 2  # fmt: skip
    assert fresnel(np.cos(brewster), 1.0, 1.5) == pytest.approx(across / 2)
    assert fresnel(np.cos(np.arcsin(1 / 1.5) + 1e-6), 1.5, 1.0) == 1.0
    assert fresnel(0.3, 1.46, 1.46) == pytest.approx(0.0)


def test_clear_plate_lets_through_what_the_series_of_its_reflections_says():
    found, events, lost = followed(200_000)
    reflected = fresnel(1.0, N_BODY, 1.0)
    through = 1 / (1 + reflected)  # (1 - R) (1 + R^2 + R^4 + ...): to and fro between face and lens
    assert found[-1].sum() == pytest.approx(through, abs=4 * np.sqrt(through * (1 - through) / 200_000))
    assert found[-1, 0, 0] == found[-1].sum()  # equal indices: nothing is turned at a wall
    assert lost == 0
    assert events[-1, :2].sum() == 0


def test_absorption_weighs_ways_by_their_length():
    slanted = (0.4, 0.0, -1.0)
    cosine = 1 / np.sqrt(1.16)
    found, _, _ = followed(50_000, direction=slanted, absorption=0.05)
    reflected, kept = fresnel(cosine, N_BODY, 1.0), np.exp(-0.05 * 8 / cosine)
    # To the face, and reflected at the lens back to it once more: further orders are below 1e-4.
    expected = (1 - reflected) * kept * (1 + reflected**2 * kept**2)
    assert found[-1].sum() == pytest.approx(expected, rel=0.01)


def test_single_wall_splits_by_fresnel_and_snell():
    """A straight way through five layers of cells: each of ten faces reflects Fresnel's share."""
    found, events, _ = followed(400_000, infill=1.2)
    share = fresnel(1.0, N_BODY, 1.2)
    outer = fresnel(1.0, N_BODY, 1.0)
    straight = (1 - share) ** 10 * (1 - outer)
    assert found[-1, 0, 0] == pytest.approx(straight, abs=0.004)
    assert found[-1, 3].sum() > 0  # turned twice, once from either side
    assert events[-1, 2] > 9.9 * straight


def test_scattering_light_is_conserved():
    strips = np.array([[0, sign, sign * 11.8, 15.6, 0.4, 7.6, 0.0] for sign in (-1.0, 1.0)])
    found, _, lost = followed(20_000, scattering=0.5, infill=1.45, strips=strips)
    assert lost == 0
    assert 0.1 < found[:2].sum() < 0.9
    assert found[0].sum() == pytest.approx(found[1].sum(), rel=0.1)  # the block is symmetric, the ray nearly central
    brighter, _, _ = followed(20_000, scattering=0.5, infill=1.45, strips=np.column_stack([strips[:, :6], [0.5, 0.5]]))
    assert brighter.sum() > found.sum()  # strips that reflect send some of it on


def test_radiance_of_the_default_sensor_by_light_and_channel():
    found = wall_modes(load_design("mini-magictac"), load_rig("digit-rgb"), paths=200_000, seed=1)
    assert found.lights == ("-x", "+x", "-y", "+y", ROOM)
    image = found.radiance.sum((0, 1, 2))
    red, green, blue = image
    assert red == pytest.approx(blue, rel=0.03)  # mirror images of each other
    assert found.radiance[-1].sum() == 0  # a dark room
    assert green > red


@pytest.mark.parametrize(
    ("changes", "rig", "complaint"),
    [
        (["cell_mm=0"], "digit-rgb", "there are no walls"),
        (["skin_mm=0.2"], "digit-rgb", "must be above 0.2"),
        ([], "white-ring", "strips alone are followed"),
    ],
)
def test_sensors_that_are_no_boxes_are_refused(changes: list[str], rig: str, complaint: str):
    with pytest.raises(ConfigError, match=f"study 'light-modes' cannot be done: .*{complaint}"):
        wall_modes(load_design("mini-magictac", changes), load_rig(rig), paths=100, seed=1)
