"""What a detector must offer to be judged, the built-in one, and how somebody else's is found."""

import importlib
import importlib.util
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from magicsim.config.presets import expanded, is_file, preset_names
from magicsim.detectors.combined import detect
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.errors import ConfigError, unknown_choice

ENTRY_POINTS = "magicsim.detectors"
"""Group of entry points whose names `--detector` accepts."""
Frame = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Detection:
    """What a detector says of one frame. Plain words and numbers, so that a plug-in needs nothing of magicsim."""

    proximity: str
    """`Normal`, `Approaching` or `Noise`."""
    contact: str
    """`Touched`, `Untouched` or `Unknown`, with everything known taken into account."""
    approach: float
    """Score that rises with the evidence for a nearby object; any scale, used for ranking alone."""
    touch: float
    """Score that rises with the evidence for a touch; any scale, used for ranking alone."""


@runtime_checkable
class Detector(Protocol):
    """A detector; one object is made without arguments for every episode."""

    def fit(self, references: Sequence[Frame]) -> None:
        """Learns the untouched sensor from its reference frames, RGB, uint8, shape (rows, columns, 3)."""

    def step(self, frame: Frame) -> Detection:
        """Judges the next frame of the stream; called once for every frame, in order.

        Anything with the four fields of `Detection` may be returned.
        """


MakeDetector = Callable[[], Detector]


class ProfileDetector:
    """The built-in detectors with one profile: temporal fusion, proximity, contact, combined detection."""

    def __init__(self, profile: DetectorProfile) -> None:
        """Takes thresholds and options."""
        self.profile = profile
        self._references: References | None = None

    def fit(self, references: Sequence[Frame]) -> None:
        """See `Detector`."""
        self._references = fuse(list(references), self.profile)

    def step(self, frame: Frame) -> Detection:
        """See `Detector`; a touch under outside light is no evidence, which its score follows."""
        if self._references is None:
            msg = "step before fit: a detector needs its references first"
            raise ConfigError(msg)
        verdict = detect(frame, self._references, self.profile)
        return Detection(
            proximity=verdict.proximity,
            contact=verdict.combined,
            approach=verdict.p_approach,
            touch=verdict.p_touch * (1 - verdict.p_noise),
        )


def built_in(profile: str | Path) -> MakeDetector:
    """Makes built-in detectors with a profile.

    Raises:
        PresetError: No such profile.
    """
    loaded = load_profile(profile)
    return lambda: ProfileDetector(loaded)


def detector_by(detector: str | MakeDetector) -> MakeDetector:
    """What makes a detector, from its class, the name of a profile, or a name as `find_detector` takes it.

    Raises:
        ConfigError: Nothing there, or not a detector.
        PresetError: No such profile.
    """
    if not isinstance(detector, str):
        return lambda: _made(getattr(detector, "__name__", "given"), detector)
    if detector in preset_names("profile") or detector.endswith(".toml"):
        return built_in(detector)
    return find_detector(detector)


def find_detector(name: str) -> MakeDetector:
    """A plug-in by `module:Class`, by `path/to/file.py:Class`, or by the name of an entry point.

    Raises:
        ConfigError: Nothing there, or not a detector.
    """
    module_name, separator, attribute = name.rpartition(":")
    if not separator:
        points = {each.name: each for each in entry_points(group=ENTRY_POINTS)}
        if name not in points:
            raise ConfigError(f"{unknown_choice('detector', name, points)}; or give module:Class or file.py:Class")
        found = _tried(points[name].load, f"detector '{name}' cannot be loaded")
    else:
        module = _load_file(module_name) if module_name.endswith(".py") else _load_module(module_name)
        if not hasattr(module, attribute):
            public = [each for each in vars(module) if not each.startswith("_")]
            raise ConfigError(unknown_choice(f"attribute of '{module_name}'", attribute, public))
        found = getattr(module, attribute)
    return lambda: _made(name, found)


def check_detection(said: object, *, who: str) -> Detection:
    """A plug-in's answer, checked.

    Raises:
        ConfigError: A field is missing, a verdict unknown, or a score not a finite number.
    """
    values = {}
    for field in Detection.__slots__:
        if not hasattr(said, field):
            msg = f"detector '{who}': step returned {type(said).__name__} without {field}; must be like Detection"
            raise ConfigError(msg)
        values[field] = getattr(said, field)
    for field, choices in (("proximity", Proximity), ("contact", Contact)):
        if values[field] not in list(choices):
            raise ConfigError(f"detector '{who}': {unknown_choice(field, str(values[field]), choices)}")
    for field in ("approach", "touch"):
        try:
            score = float(values[field])
        except (TypeError, ValueError):
            score = math.nan
        if not math.isfinite(score):
            msg = f"detector '{who}': {field} = {values[field]!r} is not allowed: must be a finite number"
            raise ConfigError(msg)
        values[field] = score
    return Detection(**values)


def _made(name: str, make: Callable[[], object]) -> Detector:
    made = _tried(make, f"detector '{name}' cannot be made without arguments")
    if not isinstance(made, Detector):
        msg = f"detector '{name}' has no methods fit and step"
        raise ConfigError(msg)
    return made


def _tried(call: Callable[[], Any], problem: str) -> Any:  # noqa: ANN401 - what somebody else's code returns
    """What a call of somebody else's code returns.

    Raises:
        ConfigError: Instead of whatever it raises, also where it ends the program: the problem, and what it said.
    """
    try:
        return call()
    except (Exception, SystemExit) as error:
        raise ConfigError(f"{problem}: {type(error).__name__}: {error}".removesuffix(": ")) from error


def _load_module(name: str) -> ModuleType:
    module: ModuleType = _tried(lambda: importlib.import_module(name), f"detector module '{name}' cannot be imported")
    return module


def _load_file(path: str) -> ModuleType:
    file = expanded(path)
    spec = importlib.util.spec_from_file_location(f"magicsim_plugin_{file.stem}", file)
    if not is_file(file) or spec is None or spec.loader is None:
        msg = f"detector file '{path}' does not exist"
        raise ConfigError(msg)
    module, loader = importlib.util.module_from_spec(spec), spec.loader
    _tried(lambda: loader.exec_module(module), f"detector file '{path}' cannot be loaded")
    return module
