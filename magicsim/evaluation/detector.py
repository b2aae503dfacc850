"""What a detector must offer to be judged, the built-in one, and how a plug-in is made and called."""

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Protocol, TypeVar, runtime_checkable

from magicsim.arrays import Frame
from magicsim.config.presets import expanded, is_file, preset_names
from magicsim.detectors.combined import behind_coat, detect, followed
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.rest import References, fuse
from magicsim.detectors.verdict import FEATURES
from magicsim.errors import ConfigError, MagicsimError, unknown_choice


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
    entropy: float | None = None
    """E [bit], where the detector has it; its spread at rest is then told, and likewise that of the next two."""
    correlation: float | None = None
    """C."""
    similarity: float | None = None
    """S."""


@runtime_checkable
class Detector(Protocol):
    """A detector; one object is made without arguments for every episode."""

    def fit(self, references: Sequence[Frame]) -> None:
        """Learns the untouched sensor from its reference frames, RGB, uint8, shape (rows, columns, 3)."""

    def step(self, frame: Frame) -> Detection:
        """Judges the next frame of the stream; called once for every frame, in order.

        Anything with the first four fields of `Detection` may be returned.
        """


MakeDetector = Callable[[], Detector]


class ProfileDetector:
    """The built-in detectors with one profile: temporal fusion, proximity, contact, combined detection."""

    def __init__(self, profile: DetectorProfile, *, is_coated: bool = False) -> None:
        """Takes thresholds and options, and whether an opaque coat hides what is outside."""
        self.profile, self.is_coated = profile, is_coated
        self._references: References | None = None

    def fit(self, references: Sequence[Frame]) -> None:
        """See `Detector`."""
        self._references = fuse(list(references), self.profile)

    def step(self, frame: Frame) -> Detection:
        """See `Detector`; a touch under outside light is no evidence, which its score follows."""
        if self._references is None:
            raise ConfigError("step before fit: a detector needs its references first")
        verdict = detect(frame, self._references, self.profile)
        if self.is_coated:
            verdict = behind_coat(verdict)
        self._references = followed(self._references, verdict, self.profile)
        return Detection(
            proximity=verdict.proximity,
            contact=verdict.combined,
            approach=verdict.p_approach,
            touch=verdict.p_touch * (1 - (0 if self.is_coated else verdict.p_noise)),
            **{name: getattr(verdict, name) for name in FEATURES},
        )


def built_in(profile: str | Path, *, is_coated: bool = False) -> MakeDetector:
    """Makes built-in detectors with a profile, which behind an opaque coat are not asked what is near."""
    loaded = load_profile(profile)
    return lambda: ProfileDetector(loaded, is_coated=is_coated)


ENTRY_POINTS = "magicsim.detectors"
"""Group of entry points whose names `--detector` accepts."""


def detector_by(detector: str | MakeDetector, *, is_coated: bool = False) -> MakeDetector:
    """The maker of a detector, from its class, what `built_in` takes, or a name as `find_detector` takes it."""
    if not isinstance(detector, str):
        return lambda: _made(getattr(detector, "__name__", "given"), detector)
    if detector in preset_names("profile") or detector.endswith(".toml"):
        return built_in(detector, is_coated=is_coated)
    return find_detector(detector)


def find_detector(name: str) -> MakeDetector:
    """A plug-in by `module:Class`, by `path/to/file.py:Class`, or by the name of an entry point.

    `ConfigError` where nothing is there, or it is not a detector.
    """
    module_name, separator, attribute = name.rpartition(":")
    if not separator:
        points = {each.name: each for each in entry_points(group=ENTRY_POINTS)}
        if name not in points:
            raise ConfigError(f"{unknown_choice('detector', name, points)}; or give module:Class or file.py:Class")
        maker = tried(points[name].load, f"detector '{name}' cannot be loaded")
    else:
        is_file_name = module_name.endswith(".py")
        problem = f"detector module '{module_name}' cannot be imported"
        load = partial(importlib.import_module, module_name)
        module = _load_file(module_name) if is_file_name else tried(load, problem)
        if not hasattr(module, attribute):
            public = [each for each in vars(module) if not each.startswith("_")]
            raise ConfigError(unknown_choice(f"attribute of '{module_name}'", attribute, public))
        maker = getattr(module, attribute)
    return lambda: _made(name, maker)


def _made(name: str, make: Callable[[], object]) -> Detector:
    detector = tried(make, f"detector '{name}' cannot be made without arguments")
    if not isinstance(detector, Detector):
        raise ConfigError(f"detector '{name}' has no methods fit and step")
    return detector


def _load_file(path: str) -> ModuleType:
    file = expanded(path)
    spec = importlib.util.spec_from_file_location(f"magicsim_plugin_{file.stem}", file)
    if not is_file(file) or spec is None or spec.loader is None:
        raise ConfigError(f"detector file '{path}' does not exist")
    module, loader = importlib.util.module_from_spec(spec), spec.loader
    sys.modules[spec.name] = module  # where dataclasses and pickle look for what their class stands in
    tried(lambda: loader.exec_module(module), f"detector file '{path}' cannot be loaded")
    return module


Returned = TypeVar("Returned")


def tried(call: Callable[[], Returned], problem: str) -> Returned:
    """The result of a call of somebody else's code, whose `MagicsimError` is raised as it is.

    `ConfigError` for anything else, also where the call ends the program: the problem, what was said, and where.
    """
    try:
        return call()
    except MagicsimError:
        raise
    except (Exception, SystemExit) as error:
        said = " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")
        raise ConfigError(f"{problem}: {said}{_place(error)}") from error


def _place(error: BaseException) -> str:
    """Where an error was raised, if not in the call itself."""
    frames = traceback.extract_tb(error.__traceback__)[2:]
    return f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
