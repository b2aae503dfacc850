"""Which sensor touches which body, by the model's names, and MuJoCo's own contact between them left out."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from magicsim.errors import ConfigError, unknown_choice
from magicsim.robot.mujoco.solids import MjModel, MjSpec, engine, geoms_of, rigid_part
from magicsim.robot.workspace import Range
from magicsim.scenes.scene import SceneConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """One sensor at a site of the model, and the body that it touches."""

    site: str
    """The sensor's frame: origin at the centre of the contact face, +z into the sensor, y along its 32 mm side."""
    body: str
    """The body that it sees and touches, with its children that have no joints; all others meet its finger by MuJoCo's
    own contact."""
    scene: SceneConfig | None = None
    """Design, rig, friction and render settings; the coupling's own where it is None. Its object does not matter."""
    faces: str | None = None
    """Site of another sensor that looks at this one, such as that on the other finger of a gripper: it is in the
    picture, with its lights (`magicsim.light.facing`)."""
    x_mm: Range = (-6.0, 6.0)
    """Part of the contact face where the lattice is fine, along x [mm]. Contact beyond is solved on coarser cells."""
    y_mm: Range = (-6.0, 6.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Attachment:
    """Numbers of a touch in a compiled model."""

    site: int
    finger: int
    """Body that the site is fixed to."""
    body: int


def compiled(spec: MjSpec, touches: Sequence[Touch]) -> MjModel:
    """Compiles an `MjSpec` with MuJoCo's own contact left out between each sensor's finger and the touched body."""
    model = spec.compile()
    for touch in touches:
        pair = find_pair(model, touch)
        for bodies in _unexcluded(model, pair):
            first, second = (_named(spec, body) for body in bodies)
            spec.add_exclude(bodyname1=first, bodyname2=second)
            model = spec.compile()
    return model


def _named(spec: MjSpec, number: int) -> str:
    """Name of a body, which gets one where it has none: exclusions go by names."""
    body = next(each for each in spec.bodies if each.id == number)
    body.name = body.name or f"body {number}"
    return str(body.name)


def find_pair(model: MjModel, touch: Touch) -> Attachment:
    """The numbers behind the names of a touch; `ConfigError` where the sensor would touch what it is fixed to."""
    site = _number(model, "site", touch.site, model.nsite)
    body = _number(model, "body", touch.body, model.nbody)
    finger = int(model.site_bodyid[site])
    if int(model.body_weldid[finger]) == int(model.body_weldid[body]):
        raise ConfigError(f"body '{touch.body}' is fixed to the sensor at site '{touch.site}': it must move against it")
    return Attachment(site=site, finger=finger, body=body)


def check_excluded(model: MjModel, touch: Touch, pair: Attachment) -> None:
    """Refuses (`ConfigError`) a model in which MuJoCo presses the body against the finger, and says what to add."""
    pairs = [each for each in _unexcluded(model, pair) if _may_collide(model, *each)]
    if not pairs:
        return
    names = (str(model.body(body).name) or f"number {body}" for body in pairs[0])
    raise ConfigError(
        f"body '{touch.body}' would touch site '{touch.site}' twice, by the sensor and by MuJoCo: add "
        '<exclude body1="{}" body2="{}"/> to <contact>, or compile with magicsim.robot.mujoco.compiled'.format(*names)
    )


def _unexcluded(model: MjModel, pair: Attachment) -> list[tuple[int, int]]:
    """Bodies with geoms of the finger and of the object whose contact the model does not leave out."""
    excluded = {frozenset((int(each) >> 16, int(each) & 0xFFFF)) for each in model.exclude_signature}
    ours, theirs = (
        [each for each in rigid_part(model, body) if model.body_geomnum[each]] for body in (pair.finger, pair.body)
    )
    return [each for each in product(ours, theirs) if frozenset(each) not in excluded]


def _may_collide(model: MjModel, finger: int, body: int) -> bool:
    ours, theirs = geoms_of(model, [finger]), geoms_of(model, [body])
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
