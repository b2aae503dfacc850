"""Which sensor touches which body, by the model's names, and MuJoCo's own contact between them left out."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from magicsim.errors import ConfigError, unknown_choice
from magicsim.robot.mujoco.solids import MjModel, MjSpec, engine
from magicsim.scenes.scene import SceneConfig

Range = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """One sensor at a site of the model, and the body that it touches."""

    site: str
    """The sensor's frame: origin at the centre of the contact face, +z into the sensor, y along its 32 mm side."""
    body: str
    """The body that it sees and touches; all others meet its finger by MuJoCo's own contact."""
    scene: SceneConfig | None = None
    """Design, rig, friction and render settings; the coupling's own where it is None. Its object does not matter."""
    faces: str | None = None
    """Site of another sensor that looks at this one, such as that on the other finger of a gripper: it is in the
    picture, with its lights (`magicsim.light.facing`)."""
    x_mm: Range = (-6.0, 6.0)
    """Part of the contact face where the lattice is fine, along x [mm]. Contact beyond is solved on coarser cells."""
    y_mm: Range = (-6.0, 6.0)
    """Likewise along y [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Attachment:
    """Numbers of a touch in a compiled model."""

    site: int
    finger: int
    """Body that the site is fixed to."""
    body: int


def compiled(spec: MjSpec, touches: Sequence[Touch]) -> MjModel:
    """Compiles a specification with MuJoCo's own contact left out between each sensor's finger and the touched body.

    Args:
        spec: `mujoco.MjSpec`; the pairs are added to it.
        touches: Sensors and bodies.

    Returns:
        `mujoco.MjModel`.

    Raises:
        ConfigError: A site or body does not exist.
    """
    model = spec.compile()
    for touch in touches:
        pair = find_pair(model, touch)
        if (pair.finger, pair.body) not in _excluded(model):
            spec.add_exclude(bodyname1=model.body(pair.finger).name, bodyname2=touch.body)
            model = spec.compile()
    return model


def find_pair(model: MjModel, touch: Touch) -> Attachment:
    """The numbers behind the names of a touch.

    Args:
        model: `mujoco.MjModel`.
        touch: Site and body by name.

    Raises:
        ConfigError: One does not exist, or the sensor would touch what it is fixed to.
    """
    site = _number(model, "site", touch.site, model.nsite)
    body = _number(model, "body", touch.body, model.nbody)
    finger = int(model.site_bodyid[site])
    if int(model.body_weldid[finger]) == int(model.body_weldid[body]):
        raise ConfigError(f"body '{touch.body}' is fixed to the sensor at site '{touch.site}': it must move against it")
    return Attachment(site=site, finger=finger, body=body)


def check_excluded(model: MjModel, touch: Touch, pair: Attachment) -> None:
    """Refuses a model in which MuJoCo itself would press the body against the sensor's finger.

    Raises:
        ConfigError: Says what to add.
    """
    if (pair.finger, pair.body) in _excluded(model) or not _may_collide(model, pair):
        return
    finger = str(model.body(pair.finger).name)
    raise ConfigError(
        f"body '{touch.body}' would touch site '{touch.site}' twice, by the sensor and by MuJoCo: add <exclude "
        f'body1="{finger}" body2="{touch.body}"/> to <contact>, or compile with magicsim.robot.mujoco.compiled'
    )


def _excluded(model: MjModel) -> set[tuple[int, int]]:
    pairs = [(int(each) >> 16, int(each) & 0xFFFF) for each in model.exclude_signature]
    return {*pairs, *((second, first) for first, second in pairs)}


def _may_collide(model: MjModel, pair: Attachment) -> bool:
    ours, theirs = (
        range(int(model.body_geomadr[body]), int(model.body_geomadr[body]) + int(model.body_geomnum[body]))
        for body in (pair.finger, pair.body)
    )
    by_masks = any(
        model.geom_contype[a] & model.geom_conaffinity[b] or model.geom_contype[b] & model.geom_conaffinity[a]
        for a, b in product(ours, theirs)
    )
    named = {frozenset((int(a), int(b))) for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True)}
    return by_masks or any(frozenset(each) in named for each in product(ours, theirs))


def _number(model: MjModel, kind: str, name: str, count: int) -> int:
    number = int(engine().mj_name2id(model, getattr(engine().mjtObj, f"mjOBJ_{kind.upper()}"), name))
    if number < 0:
        names = [str(getattr(model, kind)(each).name) for each in range(count)]
        raise ConfigError(unknown_choice(kind, name, [each for each in names if each]))
    return number
