"""How a detector is found: a profile of the built-in ones, a class, a file, or the name of an entry point."""

import importlib
import importlib.util
from collections.abc import Callable
from importlib.metadata import entry_points
from types import ModuleType

from magicsim.config.presets import expanded, is_file, preset_names
from magicsim.errors import ConfigError, unknown_choice
from magicsim.evaluation.detector import Detector, MakeDetector, built_in
from magicsim.evaluation.foreign import tried

ENTRY_POINTS = "magicsim.detectors"
"""Group of entry points whose names `--detector` accepts."""


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


def named_detector(name: str | None, *, profile: str, is_coated: bool = False) -> MakeDetector:
    """A plug-in by its name as `find_detector` takes it, or without one the built-in detectors with a profile.

    Args:
        name: Of the plug-in.
        profile: Name or file.
        is_coated: Whether the sensor has an opaque coat, behind which a built-in detector is not asked what is near.

    Raises:
        ConfigError: Nothing there, or not a detector.
        PresetError: No such profile.
    """
    return built_in(profile, is_coated=is_coated) if name is None else find_detector(name)


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
        found = tried(points[name].load, f"detector '{name}' cannot be loaded")
    else:
        module = _load_file(module_name) if module_name.endswith(".py") else _load_module(module_name)
        if not hasattr(module, attribute):
            public = [each for each in vars(module) if not each.startswith("_")]
            raise ConfigError(unknown_choice(f"attribute of '{module_name}'", attribute, public))
        found = getattr(module, attribute)
    return lambda: _made(name, found)


def _made(name: str, make: Callable[[], object]) -> Detector:
    made = tried(make, f"detector '{name}' cannot be made without arguments")
    if not isinstance(made, Detector):
        msg = f"detector '{name}' has no methods fit and step"
        raise ConfigError(msg)
    return made


def _load_module(name: str) -> ModuleType:
    module: ModuleType = tried(lambda: importlib.import_module(name), f"detector module '{name}' cannot be imported")
    return module


def _load_file(path: str) -> ModuleType:
    file = expanded(path)
    spec = importlib.util.spec_from_file_location(f"magicsim_plugin_{file.stem}", file)
    if not is_file(file) or spec is None or spec.loader is None:
        msg = f"detector file '{path}' does not exist"
        raise ConfigError(msg)
    module, loader = importlib.util.module_from_spec(spec), spec.loader
    tried(lambda: loader.exec_module(module), f"detector file '{path}' cannot be loaded")
    return module
