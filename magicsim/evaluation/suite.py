"""A suite: which objects move how, under which light and noise. The configuration of `detectors/suites/*.toml`."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config, apply_overrides, read_whole, validate
from magicsim.config.presets import find_preset
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.judge.tally import FIRST_PLACE, RECORDED, Role
from magicsim.scenes.rig import PlaceMm, Rig
from magicsim.scenes.scene import FRAMES_PER_SECOND, FrameRate, Keyframe, RenderSettings, Seed

Name = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]*$")]
MAX_TAKES = 10_000
"""Most combinations of object, path, light and seed: each is rendered, which takes a minute or so."""


SHIPPED, QUICK = "small", "quick"
"""The suite whose quick part comes with the program, and the name of that part in results and baselines."""
SETTINGS_OF_QUICK = ("resamples", "false_alarm_rate", "rest_s", "rig.camera.live")
"""What may be set where frames come with the program: nothing that they were rendered with."""


class SuiteObject(Config):
    """An object and how it is brought to the sensor."""

    name: Name
    """What it is called in results."""
    object: str
    """An object preset, or `KIND:key=value,...`."""
    role: Role
    """Whether the calibration of the shipped profiles may have seen it."""
    press_mm: Annotated[float, Field(gt=0, le=3)] = 1.0
    """Deepest press [mm], which paths give shares of; what keeps within the sensor's recommended 6 N."""
    x_mm: PlaceMm = 0.0
    """Origin of the object along x [mm]; chosen so that the contact lies inside the face."""
    y_mm: PlaceMm = 0.0
    """Origin of the object along y [mm]."""


class PathFrame(Keyframe):
    """A scene's keyframe: place and twist are added to the object's own, without gap and press there is no object."""

    press: Annotated[float, Field(ge=0, le=1)] | None = None
    """Depth instead of `gap_mm`, in units of the object's `press_mm`."""

    def _problems(self) -> Iterator[str | None]:
        if self.gap_mm is not None and self.press is not None:
            yield f"frame {self.frame} gives both gap_mm and press: must be one of them"


class SuitePath(Config):
    """How an object moves, the same for every object."""

    name: Name
    friction: Annotated[float, Field(ge=0, le=5)] = 0.0
    """Coulomb's coefficient between skin and object."""
    frames: Annotated[tuple[PathFrame, ...], Field(min_length=1)]

    def _problems(self) -> Iterator[str | None]:
        numbers = [each.frame for each in self.frames]
        if numbers[0] != 0 or any(later <= earlier for earlier, later in pairwise(numbers)):
            yield f"frames.frame = {numbers} is not allowed: must start at 0 and increase"


class SuiteLight(Config):
    """Outside light while the object is there; what a path says of the light without an object stays."""

    name: Name
    flashlight: bool = False
    """Whether a flashlight is on."""
    from_x_mm: PlaceMm = 0.0
    """Shift of the flashlight along x when the object appears [mm]."""
    to_x_mm: PlaceMm = 0.0
    """Shift of the flashlight along x when the object is gone [mm]; between them it moves evenly."""


class SuiteNoise(Config):
    """Noise of the camera; what is left out stays as in the rig."""

    name: Name
    full_well_e: Annotated[float, Field(ge=10, le=1e12)] | None = None
    """See `magicsim.camera.camera.Camera` [electrons]."""
    read_noise_e: Annotated[float, Field(ge=0, le=1e12)] | None = None
    """See `magicsim.camera.camera.Camera` [electrons]."""


class SuitePlace(Config):
    """One sensor of the suite's kind, and where it stands: another room, another print, another camera."""

    name: Name
    role: Role = "held_out"
    """Whether the calibration of the shipped profiles may have seen it."""
    settings: Annotated[tuple[str, ...], Field(max_length=100)] = ()
    """`dotted.key=value` settings of design and rig, such as `rig.room='bench'`."""


class SuiteBlock(Config):
    """Every combination of what is named here is an episode."""

    objects: Annotated[tuple[Name, ...], Field(min_length=1)]
    paths: Annotated[tuple[Name, ...], Field(min_length=1)]
    lights: Annotated[tuple[Name, ...], Field(min_length=1)]
    seeds: Annotated[tuple[Seed, ...], Field(min_length=1)] = (1,)
    """Seeds of rendering and placement."""
    places: tuple[Name, ...] = ()
    """The first place of the suite, if none is named."""


class SuiteRecording(Config):
    """An episode of a real sensor: images and a table of labels, see `magicsim.judge.recorded`."""

    name: Name
    folder: str
    """The folder, relative to the suite's file."""
    object: str = ""
    """What it shows."""
    sensor: str = RECORDED
    """Which sensor took it, such as its kind and its unit."""
    role: Role = "held_out"
    """Whether the calibration may have seen it."""


class SuiteConfig(Config):
    """A fixed set of labelled episodes."""

    schema_version: Literal[1]
    design: ElastomerDesign
    """The block; a file may give the name of a design preset instead."""
    rig: Rig
    """What surrounds it; a file may give the name of a rig preset instead."""
    seed: Seed = 0
    """Seed of the camera noise and of the resampling; another one needs no new rendering."""
    references: Annotated[int, Field(ge=1, le=1000)] = 30
    """Frames of the untouched sensor before those of the path."""
    frames_per_second: FrameRate = FRAMES_PER_SECOND
    """Frame rate [1/s]."""
    jitter_mm: Annotated[float, Field(ge=0, le=5)] = 0.0
    """Largest random shift of an object along x and y [mm], drawn from the episode's seed."""
    jitter_deg: Annotated[float, Field(ge=0, le=180)] = 0.0
    """Largest random twist of an object [degrees]."""
    false_alarm_rate: Annotated[float, Field(gt=0, lt=1)] = 0.05
    """Share of frames with nothing to detect at which detection rates are compared."""
    resamples: Annotated[int, Field(ge=99, le=100_000)] = 999
    """Bootstrap resamples of the confidence intervals."""
    render: RenderSettings = RenderSettings()
    objects: tuple[SuiteObject, ...] = ()
    paths: tuple[SuitePath, ...] = ()
    lights: tuple[SuiteLight, ...] = ()
    noises: Annotated[tuple[SuiteNoise, ...], Field(min_length=1)] = (SuiteNoise(name="rig"),)
    """The first noise and the first light of the first block are the standard condition."""
    places: Annotated[tuple[SuitePlace, ...], Field(min_length=1)] = (SuitePlace(name=FIRST_PLACE, role="training"),)
    rest_s: Annotated[float, Field(ge=0, le=36_000)] = 30.0
    """Length of a stream at rest, which false alarms are counted in, for every place and noise [s]."""
    episodes: tuple[SuiteBlock, ...] = ()
    recordings: tuple[SuiteRecording, ...] = ()

    def sensor(self, place: SuitePlace) -> tuple[ElastomerDesign, Rig]:
        """Block and rig of a place; `ConfigError` where a setting is not allowed."""
        data = {"design": self.design.model_dump(mode="json"), "rig": self.rig.model_dump(mode="json")}
        changed, source = apply_overrides(data, list(place.settings)), f"places.{place.name}"
        if unknown := sorted(set(changed) - set(data)):
            raise ConfigError(unknown_choice(f"{source}: setting of", unknown[0], data))
        design = validate(ElastomerDesign, changed["design"], source=source)
        return design, validate(Rig, changed["rig"], source=source)

    def _problems(self) -> Iterator[str | None]:
        known = {"objects": self.objects, "paths": self.paths, "lights": self.lights, "places": self.places}
        for key, entries in (*known.items(), ("noises", self.noises), ("recordings", self.recordings)):
            names = [each.name for each in entries]  # type: ignore[attr-defined]
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                yield f"{key}.name = '{twice[0]}' is given twice: names must differ"
        for block in self.episodes:
            for key, entries in known.items():
                choices = [each.name for each in entries]  # type: ignore[attr-defined]
                for name in getattr(block, key):
                    if name not in choices:
                        yield unknown_choice(f"episodes.{key}", name, choices)
        takes = sum(
            len(block.objects) * len(block.paths) * len(block.lights) * len(block.seeds) * max(1, len(block.places))
            for block in self.episodes
        )
        if takes > MAX_TAKES:
            yield f"{takes} combinations in episodes are too many: at most {MAX_TAKES}"
        if self.episodes and self.design.is_opaque:
            yield (
                "design.coat is opaque, which is not allowed in a suite: its detectors see through the sensor; must be "
                "none or a half mirror"
            )
        if not self.episodes and not self.recordings:
            yield "episodes and recordings are both empty: a suite needs at least one of them"


def load_suite(name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None) -> SuiteConfig:
    """Reads a suite by preset name or path and puts its design and rig in place.

    Overrides are `dotted.key=value`; `design.` and `rig.` reach into those files. A seed stands for the file's.

    Raises:
        PresetError: The suite, its design or its rig does not exist.
        ConfigError: The content is not acceptable.
    """
    path = find_preset("suite", name)
    data = read_whole(path, overrides)
    for each in data.get("recordings", ()) if isinstance(data.get("recordings"), list) else ():
        if isinstance(each, dict) and isinstance(each.get("folder"), str):
            each["folder"] = str(path.parent / each["folder"])
    if seed is not None:
        data["seed"] = seed
    suite = validate(SuiteConfig, data, source=path.name)
    for each in suite.objects:
        try:
            parse_object(each.object)
        except ConfigError as error:
            raise ConfigError(f"{path.name}: objects.{each.name}: {error}") from None
    for place in suite.places:
        suite.sensor(place)
    return suite


def refuse_settings_of_frames(settings: Sequence[str], *, quick: bool, existing: bool) -> None:
    """Refuses (`ConfigError`) settings that frames cannot follow which come with the program, or exist already.

    A recording says nothing of its sensor, which may be set.
    """
    option, allowed = ("--on", ("design", "rig", "frames_per_second")) if existing else ("--quick", ())
    for key in (each.partition("=")[0].strip() for each in settings if quick or existing):
        if key not in SETTINGS_OF_QUICK and key.partition(".")[0] not in allowed:
            raise ConfigError(
                f"--set {key} is not allowed with {option}, whose frames exist: must be one of "
                f"{', '.join((*SETTINGS_OF_QUICK, *allowed))}; without {option} frames are rendered"
            )
