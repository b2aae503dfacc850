import pytest

from magicsim.errors import ConfigError
from magicsim.robot.mujoco import Touch, compiled
from magicsim.robot.mujoco.pair import check_excluded, find_pair

from .models import body

BALL = "<geom type='sphere' size='.005'/>"
TOUCH = Touch(site="sensor", body="thing")


def test_compiled_leaves_out_the_contact_of_the_pair_alone():
    import mujoco

    spec = body("<geom type='sphere' size='.005' pos='0 0 -.016'/>")
    data = mujoco.MjData(spec.compile())
    mujoco.mj_forward(spec.compile(), data)
    assert data.ncon == 1
    model = compiled(spec, [TOUCH, TOUCH])
    assert model.nexclude == 1
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    check_excluded(model, TOUCH, find_pair(model, TOUCH))


def test_contact_that_mujoco_would_answer_too_is_refused():
    model = body(BALL).compile()
    with pytest.raises(ConfigError, match='add <exclude body1="table" body2="thing"/>'):
        check_excluded(model, TOUCH, find_pair(model, TOUCH))


def test_contact_of_a_child_without_joints_is_left_out_or_refused():
    import mujoco

    spec = body("<geom type='sphere' size='.001'/><body pos='0 0 -.016'><geom type='sphere' size='.005'/></body>")
    spec.add_exclude(bodyname1="table", bodyname2="thing")
    model = spec.compile()
    pair = find_pair(model, TOUCH)
    with pytest.raises(ConfigError, match='add <exclude body1="table" body2="number 3"/>'):
        check_excluded(model, TOUCH, pair)
    model = compiled(spec, [TOUCH])
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    check_excluded(model, TOUCH, find_pair(model, TOUCH))


def test_geoms_that_do_not_collide_need_no_exclusion():
    model = body("<geom type='sphere' size='.005' contype='0' conaffinity='0'/>").compile()
    check_excluded(model, TOUCH, find_pair(model, TOUCH))


@pytest.mark.parametrize(
    ("touch", "told"),
    [
        (Touch(site="senser", body="thing"), r"unknown site 'senser'.*sensor"),
        (Touch(site="sensor", body="ball"), r"unknown body 'ball'.*thing"),
        (Touch(site="sensor", body="table"), "body 'table' is fixed to the sensor at site 'sensor'"),
        (Touch(site="sensor", body="world"), "body 'world' is fixed to the sensor"),
    ],
)
def test_unknown_names_and_fixed_bodies_are_refused(touch: Touch, told: str):
    with pytest.raises(ConfigError, match=told):
        find_pair(body(BALL).compile(), touch)
