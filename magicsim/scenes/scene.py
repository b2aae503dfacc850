"""A scene: a design on a rig, and what moves. The configuration of `scenes/*.toml`."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from magicsim.camera.disturbances import readout_problem
from magicsim.config.models import Config, load_preset
from magicsim.config.named_files import MODEL_SUFFIX, FileName
from magicsim.geometry.design import FACET_MM, ElastomerDesign
from magicsim.geometry.limits import CoreFailure
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.geometry.objects.rigid_object import AngleDeg
from magicsim.scenes.refusals import flashlight_problem, gap_refusal, sensor_refusal
from magicsim.scenes.rig import PlaceMm, Rig

Count = Annotated[int, Field(ge=1, le=256)]
GapMm = Annotated[float, Field(ge=-12, le=2000)]
Seed = Annotated[int, Field(ge=0, lt=2**31)]
MAX_FRAMES = 100_000
"""Most scored frames of an episode, nearly two hours at 15 a second: all of them are planned before the first."""
FrameNumber = Annotated[int, Field(ge=0, lt=MAX_FRAMES)]
FrameRate = Annotated[float, Field(ge=0.001, le=1000)]
"""Down to a frame in a quarter of an hour [1/s]."""
FRAMES_PER_SECOND = 15.0
"""Frame rate of all that is filmed and does not say another [1/s]."""


class TaxelSettings(Config):
    """A grid of taxels over the contact face, and what is known of each; row 0 is at +y, column 0 at -x."""

    rows: Count = 16
    """Taxels along y."""
    columns: Count = 12
    """Taxels along x."""
    unit: Literal["N", "MPa"] = "N"
    """Force of each taxel (`taxel_force_n`), or force per undeformed area (`taxel_traction_mpa`)."""
    skin: bool = True
    """Largest stretch and von Mises stress of the skin, on the whole and below each taxel."""
    infill: bool = True
    """Shear of the infill, on the whole and below each taxel; designs without infill have none."""

    def has_infill(self, design: ElastomerDesign) -> bool:
        """Whether the shear of the infill is among the fields of a design."""
        return self.infill and design.has_grid and design.materials.infill is not None


class Keyframe(Config):
    """State at one frame; between keyframes everything moves linearly, what is absent stays absent."""

    frame: FrameNumber
    """Index among the scored frames (the reference frames come before and are not counted)."""
    gap_mm: GapMm | None = None
    """Distance of the object's highest point from the undeformed contact face [mm], negative when pressed; left out
    means that there is no object."""
    x_mm: PlaceMm = 0.0
    """Object's origin along x [mm]."""
    y_mm: PlaceMm = 0.0
    """Object's origin along y [mm]."""
    twist_deg: AngleDeg = 0.0
    """Object's rotation about z [degrees]."""
    flashlight: bool = False
    """Whether the outside light is on, from this frame to the next keyframe."""
    light_x_mm: PlaceMm = 0.0
    """Shift of the flashlight along x [mm]."""


class ContactSettings(Config):
    """How skin and object meet, and what light sees between them."""

    friction: Annotated[float, Field(ge=0, le=5)] = 0.0
    """Coulomb's coefficient between skin and object."""
    rate_dependent: bool = False
    """Whether the body relaxes from frame to frame (it needs a Prony series); otherwise its stiffness is long-term."""
    recovers: bool = False
    """Whether a rate-dependent body goes on relaxing after the object has left: a dent stays for a while, is seen, and
    is found by a second touch. Otherwise the untouched sensor is the drawn one."""
    infill_yield_mpa: Annotated[float, Field(ge=1e-6, le=10)] | None = None
    """Shear stress at which the infill flows [MPa]; it never does by default. Then earlier touches matter, a dent stays
    and is seen, and rows say what was dissipated; nothing relaxes besides. `design.limits` has a range of it."""
    wall_buckling_strain: Annotated[float, Field(ge=0.01, le=0.35)] | None = None
    """Squeeze along a wall from which on it carries no more; without it the law of walls is bounded at 0.35."""
    wall_tear_elongation: Annotated[float, Field(ge=0.05, le=10)] | None = None
    """Elongation at which walls tear, 2.2 for 220 %; they never do by default. No image shows torn walls: such a touch
    is refused."""
    max_iterations: Annotated[int, Field(ge=1, le=1_000_000)] = 2000
    """Iterations of one frame's equilibrium before the press is refused: its bound on time, counted so that no clock
    decides about a result. An iteration takes 0.1 s at 15,000 unknowns; the hardest valid press that is known needs
    874."""
    quality: Literal["full", "control"] = "full"
    """How finely equilibria are solved, see `deform.quality`: control is a third to a ninth of the work, with forces
    of balls 3 to 9 % too high, of a box 1 to 4 % (`docs/benchmarks/tiers.json`)."""
    coupling: Literal["wet", "dry"] = "wet"
    """Wet: the tacky skin couples optically to the object. Dry: a thin film of air stays between them."""
    film_mm: Annotated[float, Field(ge=0.01, le=0.1)] = 0.02
    """Thickness of the film of air in dry contact [mm]."""

    def _problems(self) -> Iterator[str | None]:
        if self.recovers and not self.rate_dependent:
            yield "recovers = true is not allowed with rate_dependent = false: a body without memory keeps no dent"
        for name in ("infill_yield_mpa", "wall_tear_elongation"):
            if getattr(self, name) is not None and self.rate_dependent:
                yield (
                    f"{name} = {getattr(self, name):g} is not allowed with rate_dependent = true: what relaxes neither "
                    "flows nor tears"
                )

    @property
    def failure(self) -> CoreFailure:
        """How the printed core fails."""
        return CoreFailure(
            infill_yield_mpa=self.infill_yield_mpa, wall_buckling_strain=self.wall_buckling_strain,
            wall_tear_elongation=self.wall_tear_elongation,
        )  # fmt: skip

    @property
    def keeps_dent(self) -> bool:
        """Whether a touch may leave something behind that is seen."""
        return self.recovers or self.infill_yield_mpa is not None

    @property
    def memory(self) -> str | None:
        """What makes the block remember earlier frames, friction apart; None where nothing does."""
        if self.rate_dependent:
            return "contact.rate_dependent = True"
        return f"contact.infill_yield_mpa = {self.infill_yield_mpa:g}" if self.infill_yield_mpa is not None else None


RECORDED_SAMPLES = 32
"""Paths of each pixel of the careful untouched image that are recorded at most: what an object changes by them has
little noise, and every one takes memory and time in each frame."""


class RenderSettings(Config):
    """How radiance is computed."""

    estimator: Literal["fluence", "path"] = "fluence"
    """Cached fluence, or Mitsuba's volumetric path tracer."""
    samples: Annotated[int, Field(ge=1, le=65536)] = 8
    """Camera samples a pixel; powers of two are spread most evenly over it."""
    particles: Annotated[int, Field(ge=100, le=100_000_000)] = 24_000
    """Light particles shared by the LED strips; a flashlight gets as many again (a quarter in images without an anchor
    that show no object), the room a quarter."""
    forward_collisions: Annotated[int, Field(ge=0, le=64)] = 8
    """First collisions of a camera path in an infill with `anisotropy` that follow its true phase function; from then
    on, and with 0 from the start, scattering is reduced to isotropic."""
    still_mm: Annotated[float, Field(ge=0, le=0.1)] = 0.001
    """Vertices that a press moves by no more than this are rendered where they were, and none is rendered further than
    this from its place [mm]; 0.001 is a hundredth of a pixel of the default camera."""
    reuse_mm: Annotated[float, Field(ge=0, le=0.1)] = 0.005
    """Recorded camera paths serve where no surface near one that they meet has moved by more than this [mm]; 0.005 is a
    twentieth of a pixel of the default camera."""
    light_change: Annotated[float, Field(ge=0, le=1)] = 0.015
    """Relative change of the light in the grid, root mean square, that a contact must be expected to make before a
    touched frame traces its particles; below it the light of just before contact serves. Measured changes are half
    to one and a half of the expected ones (`benchmarks/touch_light.py`); 0 traces always."""
    facet_mm: Annotated[float, Field(ge=0.05, le=5)] = FACET_MM
    """Length to which the edges of the rendered contact face are split [mm]: rims of dents bend over tenths of a
    millimetre. Cells whose pitch is no larger stay whole, and do not bulge."""
    anchor_samples: Annotated[int, Field(ge=0, le=65536)] = 128
    """Camera samples of the untouched state, to which every frame is anchored; 0 means no anchor."""
    anchor_particles: Annotated[int, Field(ge=100, le=100_000_000)] = 1_200_000
    """Light particles of the untouched state."""
    anchor_seed: Seed = 0
    """Monte Carlo seed of the untouched state: a property of the sensor, the same for all its episodes."""
    tier: Literal["true", "fast"] = "true"
    """Fast: pictures of touches come from a model that was distilled from true frames (`magicsim distil`), those of
    what is near, of a flashlight and of what passes by compressed transport. Mechanics are those of the true tier."""
    model: FileName | None = None
    """File of that model, `*.touch`; by default one that comes with the program, where one knows the sensor."""
    outside_domain: Literal["true", "refuse"] = "true"
    """What becomes of touches that the model does not know: true frames, or an error."""

    @model_validator(mode="before")
    @classmethod
    def _read_words(cls, data: object) -> object:
        """Takes `true` without quotes, a truth value to TOML, for the word."""
        if not isinstance(data, Mapping):
            return data
        return {
            key: "true" if key in {"tier", "outside_domain"} and value is True else value for key, value in data.items()
        }

    def _problems(self) -> Iterator[str | None]:
        # By its ending a file is known as one, whose content is a part of every key.
        if self.model is not None and not self.model.lower().endswith(MODEL_SUFFIX):
            yield f"model = '{self.model}' is not allowed: must end with {MODEL_SUFFIX}"

    @property
    def is_recorded(self) -> bool:
        """Whether paths through the untouched sensor are recorded, to which every frame is anchored."""
        return self.estimator == "fluence" and self.anchor_samples > 0


class OutputSettings(Config):
    """What is computed beside frames and the table of truth; leave out what is not needed."""

    contact_mask: bool = True
    """Contact mask in image space for every frame."""
    displacements: bool = True
    """Displacements of all lattice nodes for every frame."""
    depth_map: bool = False
    """How far the contact face is pressed in, in image space, for every frame."""
    taxels: TaxelSettings | None = None
    """Forces on a grid of taxels, stretch and stress of the skin, shear of the infill; none by default."""
    preview: bool = True
    """Animated preview."""
    mcap: bool = False
    """The episode as an MCAP file (extra `mcap`)."""
    report: bool = True
    """HTML report, which needs the detectors."""

    @classmethod
    def nothing(cls) -> Self:
        """Frames and the table of truth alone."""
        return cls(contact_mask=False, displacements=False, preview=False, report=False)


class SceneConfig(Config):
    """One episode of one sensor."""

    schema_version: Literal[1]
    design: ElastomerDesign
    """The block; a file may give the name of a design preset instead."""
    rig: Rig
    """What surrounds it; a file may give the name of a rig preset instead."""
    seed: Seed = 0
    """Seed of everything random in the episode."""
    references: Annotated[int, Field(ge=0, le=1000)] = 30
    """Frames of the untouched sensor before the scored ones."""
    frames_per_second: FrameRate = FRAMES_PER_SECOND
    """Frame rate [1/s]."""
    object: ObjectConfig | None = None
    """What approaches; a file may give the name of an object preset instead."""
    contact: ContactSettings = ContactSettings()
    render: RenderSettings = RenderSettings()
    output: OutputSettings = OutputSettings()
    keyframes: Annotated[tuple[Keyframe, ...], Field(min_length=1)]
    """States in order of frame; the last one ends the episode."""

    def _problems(self) -> Iterator[str | None]:
        frames = [keyframe.frame for keyframe in self.keyframes]
        if frames[0] != 0 or any(later <= earlier for earlier, later in pairwise(frames)):
            yield f"keyframes.frame = {frames} is not allowed: must start at 0 and increase"
        if self.object is None and any(keyframe.gap_mm is not None for keyframe in self.keyframes):
            yield "object is missing: a keyframe gives gap_mm, so [object] must say what approaches"
        yield sensor_refusal(self.design, self.rig, is_recorded=self.render.is_recorded)
        for name, value in asdict(self.contact.failure).items() if self.design.cell_mm == 0 else ():
            if value is not None:
                yield f"contact.{name} = {value:g} is not allowed for a block without infill and walls (cell_mm = 0)"
        for place, keyframe in enumerate(self.keyframes):
            found = None if keyframe.gap_mm is None else gap_refusal(self.design, self.rig, keyframe.gap_mm)
            yield None if found is None else f"keyframes.{place}.gap_mm{found}"
            yield flashlight_problem(self.rig, keyframe.light_x_mm) if keyframe.flashlight else None
        camera, rate = self.rig.camera, self.frames_per_second
        if problem := readout_problem(camera.shutter, rows=camera.rows, frames_per_second=rate):
            yield f"rig.{problem}"

    @property
    def lit(self) -> tuple[bool, bool, bool]:
        """Whether any light of the untouched sensor shines in red, green and blue."""
        return self.rig.lit(is_opaque=self.design.is_opaque)

    @property
    def frame_count(self) -> int:
        """Number of scored frames."""
        return self.keyframes[-1].frame + 1


def load_scene(name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None) -> SceneConfig:
    """Reads a scene by preset name or path and puts its design and rig in place.

    Overrides are `dotted.key=value`; `design.` and `rig.` reach into those files. A seed stands for the file's.

    Raises:
        PresetError: The scene, its design or its rig does not exist.
        ConfigError: The content is not acceptable.
    """
    return load_preset(SceneConfig, "scene", name, overrides, seed=seed)
