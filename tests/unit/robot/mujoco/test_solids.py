import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.robot.mujoco.solids import body_object, rigid_part

from .models import body

BODY = 2
WEDGE = "<mesh name='wedge' vertex='0 0 0 .01 0 0 0 .01 0 0 0 .01'/>"


def thing(geoms: str, assets: str = ""):
    return body_object(body(geoms, assets=assets).compile(), BODY)


@pytest.mark.parametrize(
    ("geom", "extents_mm", "volume_mm3"),
    [
        ("type='sphere' size='.005'", (10, 10, 10), 4 / 3 * np.pi * 125),
        ("type='capsule' size='.003 .004'", (6, 6, 14), np.pi * 9 * 8 + 4 / 3 * np.pi * 27),
        ("type='cylinder' size='.003 .004'", (6, 6, 8), np.pi * 9 * 8),
        ("type='box' size='.003 .004 .005'", (6, 8, 10), 480),
        ("type='ellipsoid' size='.003 .004 .005'", (6, 8, 10), 4 / 3 * np.pi * 60),
        ("type='mesh' mesh='wedge'", None, 1000 / 6),
    ],
)
def test_geom_keeps_extents_and_volume(geom: str, extents_mm: tuple[float, ...] | None, volume_mm3: float):
    solid = thing(f"<geom {geom}/>", WEDGE if "mesh" in geom else "")[0].shape()
    if extents_mm is not None:
        assert [solid.support_mm(axis) + solid.support_mm(-axis) for axis in np.eye(3)] == pytest.approx(extents_mm)
    mesh = solid.mesh()
    assert mesh.is_watertight()
    assert mesh.volume_mm3() == pytest.approx(volume_mm3, rel=0.01)
    distance, normal = solid.distance(mesh.vertices)
    assert np.abs(distance).max() < 0.02
    centre = mesh.vertices.mean(0)
    assert (np.einsum("pi,pi->p", normal, mesh.vertices - centre) > 0).mean() > 0.9


def test_several_geoms_are_one_solid_in_the_body_frame():
    found, frame = thing("<geom type='box' size='.004 .004 .002'/><geom type='sphere' size='.003' pos='0 0 .004'/>")
    assert frame is None
    solid = found.shape()
    assert solid.support_mm(np.array([0, 0, 1.0])) == pytest.approx(7, rel=1e-3)
    assert solid.support_mm(np.array([0, 0, -1.0])) == pytest.approx(2, rel=1e-3)


def test_only_geoms_that_collide_press_where_there_are_any():
    found, frame = thing(
        "<geom type='box' size='.05 .05 .05' contype='0' conaffinity='0' rgba='1 0 0 1'/>"
        "<geom type='sphere' size='.003' mass='.01'/>"
    )
    assert found.shape().support_mm(np.array([1.0, 0, 0])) == pytest.approx(3)
    assert found.color == (1, 0, 0)
    assert frame == 2


TIP = """<geom type='box' size='.004 .004 .002' mass='.01'/>
    <body pos='0 .01 0' quat='.7071068 .7071068 0 0'><body pos='.001 .002 0' euler='0 0 30'>
        <geom type='box' size='.001 .001 .003'/>{}</body></body>"""
"""A plate, and 10 mm aside a post along y, which two welds turn and lift by 2 mm."""


def test_children_without_joints_belong_to_the_body():
    found, frame = thing(TIP.format("<body pos='.5 0 0'><joint/><geom type='sphere' size='.09'/></body>"))
    solid = found.shape()
    assert frame is None
    assert solid.mesh().volume_mm3() == pytest.approx(8 * 8 * 4 + 2 * 2 * 6, rel=0.02)
    turned = np.cos(np.pi / 6) + np.sin(np.pi / 6)
    for axis, reach in (((0, 1, 0), 13), ((0, 0, 1), 2 + turned), ((1, 0, 0), 4), ((0, -1, 0), 4)):
        assert solid.support_mm(np.array(axis, float)) == pytest.approx(reach, abs=0.1)


def test_body_whose_geometry_hangs_on_a_child_has_the_geometry_of_the_child():
    found, frame = thing("<body pos='0 0 .01'><geom type='sphere' size='.003' mass='.01'/></body>")
    assert found.shape().mesh().volume_mm3() == pytest.approx(4 / 3 * np.pi * 27, rel=0.01)
    assert frame == 1


def test_mocap_child_of_the_world_is_a_body_of_its_own():
    import mujoco

    text = "<mujoco><worldbody>{}<body mocap='true'>{}</body></worldbody></mujoco>"
    model = mujoco.MjSpec.from_string(text.format(*["<geom type='sphere' size='.005'/>"] * 2)).compile()
    assert list(rigid_part(model, 0)) == [0]


@pytest.mark.parametrize(
    ("geoms", "assets", "told"),
    [
        ("", "", "body 'thing' has no geometry"),
        ("<geom type='sphere' size='.2' mass='1'/>", "", "measures 400 x 400 x 400 mm: must be 0.01 to 200 mm"),
    ],
)
def test_body_that_cannot_press_is_refused_in_one_line(geoms: str, assets: str, told: str):
    with pytest.raises(ConfigError, match=told) as error:
        thing(geoms + "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>", assets)
    assert "\n" not in str(error.value)


def test_plane_is_refused():
    import mujoco

    spec = mujoco.MjSpec.from_string(
        "<mujoco><worldbody><body><geom name='ground' type='plane' size='1 1 1'/></body></worldbody></mujoco>"
    )
    with pytest.raises(ConfigError, match="geom 'ground' is a plane, which cannot press on a sensor: must be sphere"):
        body_object(spec.compile(), 1)
