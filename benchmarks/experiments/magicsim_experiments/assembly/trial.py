"""What a trial begins with and what it gives: the gripper takes the plug; see `assembly.playing`.

What could tell a teleoperator that plug and base meet: SSIM of the frames, the contact detector, the force label.

SSIM is scikit-image's (extra `task`), on RGB frames of 8 bits, against the mean of the frames without a grasped object.
"""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, field, replace
from functools import partial

import numpy as np
from manifold3d import Manifold

from magicsim.arrays import Frame
from magicsim.detectors.combined import detect
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.rest import References, fuse
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.plain import PlugObject
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.load import Hold
from magicsim.robot.grip.truth import GripMoment
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace
from magicsim_experiments.assembly.meeting import Jack, MetLoad, plug_elements
from magicsim_experiments.assembly.stages import AssemblyConfig, Step, TrialStage, timeline
from magicsim_experiments.task.hand import colored

DARK = (0.03, 0.03, 0.03)
"""Diffuse reflectance in linear RGB; published is a dark base, the number is assumed."""
PLATE_MM, RIDGE_MM = 40.0, 12.0
"""Half width of the plate along x and z, and of the ridge along x [mm]; assumed, as all sizes here."""
HIGH_MM, FLOOR_MM = 6.0, 5.0
"""Height of the ridge over the plate, and thickness below the hole [mm]."""
APART_MM = 0.5
"""Distance between the ridge and the faces that hold the plug [mm]."""
AROUND = 32
"""Segments of the hole."""


def base_body(jack: Jack, *, apart_mm: float) -> SurfaceMesh:
    """The base in the jack's frame, with its colour, between contact faces that hold the plug so far apart."""
    radius, chamfer, depth = jack.radius_mm, jack.chamfer_mm, jack.depth_mm
    ridge = max(apart_mm / 2 - APART_MM, 0.1)
    solid = _block(RIDGE_MM, ridge, 0.0, HIGH_MM) + _block(PLATE_MM, PLATE_MM, HIGH_MM, depth + HIGH_MM + FLOOR_MM)
    hole = Manifold.cylinder(depth + 1, radius, radius, AROUND).translate((0, 0, -1))
    mouth = Manifold.cylinder(2 * chamfer + 1e-3, radius + 2 * chamfer, radius, AROUND).translate((0, 0, -chamfer))
    return colored(solid - (hole + mouth).rotate((-90, 0, 0)), DARK)


def _block(half_x: float, half_z: float, low: float, high: float) -> Manifold:
    size = (2 * half_x, high - low, 2 * half_z)
    return Manifold.cube(size).translate((-half_x, low, -half_z))


Vector = tuple[float, ...]
OPEN_MM = 12.0
"""How far the faces open [mm]; assumed."""
PLACE = ObjectPlace(y_mm=6.0)
"""Where the fingers take the handle: towards their tips, the pin beyond them."""
SPACE = Workspace(
    x_mm=(-1.5, 1.5), y_mm=(0.0, 8.0), twist_deg=(-15.0, 15.0), tilt_x_deg=(-15.0, 15.0), tilt_y_deg=(-15.0, 15.0),
    gap_mm=(-1.5, 20.0),
)  # fmt: skip
"""Where the plug may go in the grip; one that turns out of it counts as lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What does not change from trial to trial."""

    config: AssemblyConfig = field(default_factory=AssemblyConfig)
    timeline: Sequence[Step] = field(default_factory=lambda: timeline(AssemblyConfig()))
    place: ObjectPlace = PLACE
    """Where the fingers take the handle."""
    references: int = 30
    """Frames of the untouched fingers, for the detectors."""
    samples: int = 1
    """Pairs of frames of each step, the last one at its end, the others evenly along its way; where the base stops it
    after fewer equilibria, it is gone again in as many."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """One step of a trial, labels and pictures."""

    step: Step
    outcome: Hold
    time_s: float
    """Since the fingers began to close [s]."""
    base_force_n: Vector
    """Force of the base on the plug, in the gripper's frame; where the plug is lost, in the last balance before [N]."""
    base_torque_nmm: Vector
    """About the plug's origin [N mm]."""
    normal_n: float
    """Mean normal force of both fingers [N]."""
    place: ObjectPlace
    """The plug in the gripper's frame."""
    limit: str | None
    """The coordinate of it at whose end in the workspace the plug was lost."""
    slid_mm: float
    """How far it slid in the grip on the way to this step [mm]."""
    images: tuple[Frame, Frame]
    """Upper and lower finger's frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gripped:
    """The plug in the grip, from which each trial begins."""

    plug: PlugObject
    setup: Setup
    moment: GripMoment
    load: MetLoad
    """Weight of the plug, no base yet."""
    references: tuple[list[Frame], list[Frame]]
    """Frames of the upper and of the lower finger with nothing between them."""
    closing: tuple[GripMoment, ...] = ()
    """The fingers on their way to the plug, of which further pairs of frames of the first step are taken."""


def base_of(plug: PlugObject, setup: Setup | None = None) -> SurfaceMesh:
    """The base's body, which a gripper shows that was built with it as its `companion`."""
    config = (setup or Setup()).config
    return base_body(config.jack, apart_mm=2 * plug.radius_mm - config.squeeze_mm)


def take_plug(gripper: Gripper, plug: PlugObject, setup: Setup | None = None) -> Gripped:
    """Films the empty fingers, and grips the plug.

    Raises:
        ConfigError: The plug does not fit, drops at once, or lies outside of a finger's workspace.
    """
    setup = setup or Setup()
    config = setup.config
    gripper.reset()
    references: tuple[list[Frame], list[Frame]] = ([], [])
    for finger, own in zip(gripper.fingers, references, strict=True):
        finger.remove_object()
        own += [finger.frame().image for _ in range(setup.references)]
    weight = MetLoad.of_mass(config.mass_g, down=(0.0, 1.0, 0.0))
    load = replace(weight, elements=plug_elements(plug), jack=config.jack, contact=config.contact)
    touching, closing = gripper.touching_width_mm, []
    for left in range(setup.samples - 1, 0, -1):
        gripper.close(touching + OPEN_MM * left / setup.samples, place=setup.place)
        closing.append(gripper.now())
    gripper.close(touching - config.squeeze_mm, place=setup.place)
    if gripper.hold(load=load) is Hold.DROPPED:
        msg = f"squeeze_mm = {config.squeeze_mm:g} is not allowed: a plug of {load.weight_n:.3g} N drops at once"
        raise ConfigError(msg)
    return Gripped(
        plug=plug, setup=setup, moment=gripper.now(), load=load, references=references, closing=tuple(closing)
    )


def check_plug(plug: object) -> PlugObject:
    """The plug of a scene."""
    if not isinstance(plug, PlugObject):
        kind = getattr(plug, "kind", None)
        raise ConfigError(f"object.kind = {kind!r} is not allowed here: an assembly needs a 'plug'")
    return plug


Similarity = Callable[[Frame, Frame], float]
PROFILE = "calibrated"
GREY_LEVELS = 255


@dataclass(frozen=True, slots=True, kw_only=True)
class Cues:
    """One step of a trial, as its cues are."""

    stage: TrialStage
    outcome: str
    ssim: float
    """Mean of both fingers' SSIM, 1 for the image without a grasped object."""
    ssim_fingers: tuple[float, float]
    """Upper and lower finger."""
    similarity: float
    """Mean grid similarity S of both fingers, which the contact detector judges, 0..1."""
    verdicts: tuple[str, str]
    """Contact verdict of the upper and of the lower finger, read together with proximity."""
    time_s: float
    """Since the fingers began to close [s]."""
    force_n: tuple[float, ...]
    """Label: force of the base on the plug in the gripper's frame; of the last balance where it is lost [N]."""
    force_size_n: float
    """Size of that force [N]."""
    torque_nmm: tuple[float, ...]
    """Label: its torque about the plug's origin [N mm]."""
    normal_n: float
    """Label: mean normal force of the fingers [N]."""
    slid_mm: float
    """Label: how far the plug slid in the grip on the way to this step [mm]."""
    place: tuple[float, ...]
    """Label: the plug in the gripper's frame: x, y, z [mm], twist, tilt about x and about y [degrees]."""
    limit: str | None
    """The coordinate of it at whose end in the workspace the plug was lost."""


def check_references(count: int) -> None:
    """Refuses a number of reference frames of which nothing can be learned, before any is rendered."""
    least = load_profile(PROFILE).background_count
    if count < least:
        raise ConfigError(f"references = {count} is not allowed with task assembly: must be at least {least}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """What is known of both fingers without an object, against which frames are read."""

    empty: tuple[Frame, Frame]
    """Mean frame of each finger."""
    references: tuple[References, References]
    profile: DetectorProfile

    @classmethod
    def learned(cls, references: tuple[Sequence[Frame], Sequence[Frame]]) -> "Reader":
        """From frames of the upper and of the lower finger with nothing between them.

        There are at least as many as the profile's temporal fusion takes.
        """
        found = load_profile(PROFILE)
        upper, lower = (np.mean(frames, axis=0).round().astype(np.uint8) for frames in references)
        return cls(
            empty=(upper, lower), references=(fuse(references[0], found), fuse(references[1], found)), profile=found
        )

    def read(self, moment: Moment) -> Cues:
        """All cues of one step."""
        similarity = structural_similarity()
        ssim = [float(similarity(image, empty)) for image, empty in zip(moment.images, self.empty, strict=True)]
        verdicts = [detect(image, own, self.profile) for image, own in zip(moment.images, self.references, strict=True)]
        return Cues(
            stage=moment.step.stage, outcome=moment.outcome.value, ssim=float(np.mean(ssim)),
            ssim_fingers=(ssim[0], ssim[1]), similarity=float(np.mean([verdict.similarity for verdict in verdicts])),
            verdicts=(verdicts[0].combined.value, verdicts[1].combined.value), time_s=moment.time_s,
            force_n=moment.base_force_n, force_size_n=float(np.linalg.norm(moment.base_force_n)),
            torque_nmm=moment.base_torque_nmm, normal_n=moment.normal_n, slid_mm=moment.slid_mm,
            place=astuple(moment.place), limit=moment.limit,
        )  # fmt: skip


def structural_similarity() -> Similarity:
    """SSIM of two RGB frames, mean over pixels and channels (Wang et al. 2004), 1 for equal ones."""
    try:
        from skimage.metrics import structural_similarity as ssim
    except ImportError:
        msg = "SSIM needs the package scikit-image, which is not installed: pip install 'magicsim-experiments[task]'"
        raise ConfigError(msg) from None
    return partial(ssim, channel_axis=-1, data_range=GREY_LEVELS)
