"""Which kinds of studies there are, each loaded when it is asked for."""

import importlib
import importlib.metadata
import importlib.util
from collections.abc import Mapping
from typing import cast

from magicsim.errors import ConfigError, unknown_choice
from magicsim_experiments.study.protocol import Study
from magicsim_experiments.study.settings import StudyConfig

KINDS: dict[str, str] = {
    "alignment": "magicsim_experiments.study.learned.alignment:Alignment",
    "compare": "magicsim_experiments.study.compare:Compare",
    "deformation-law": "magicsim_experiments.study.mechanics.deformation_law:DeformationLaw",
    "fusion": "magicsim_experiments.study.fusion:Fusion",
    "light-modes": "magicsim_experiments.study.lighting.light_modes:LightModes",
    "limits": "magicsim_experiments.study.mechanics.limits:Limits",
    "localisation": "magicsim_experiments.study.learned.localisation:Localisation",
    "manufacturing": "magicsim_experiments.study.mechanics.manufacturing:Manufacturing",
    "ranging": "magicsim_experiments.study.learned.ranging:Ranging",
    "resolution": "magicsim_experiments.study.learned.resolution:Resolution",
    "wear": "magicsim_experiments.study.learned.wear:Wear",
}
"""Kind of a study, as its file names it, and `module:class` of what does it."""
EXTRAS = {"torch": "learn", "safetensors": "learn"}
"""Package that a study may need, and the extra that brings it."""


def study_class(kind: str, kinds: Mapping[str, str] | None = None) -> type[Study]:
    """The class of a kind of study.

    Args:
        kind: What the file's key `kind` says.
        kinds: Kinds to choose from; `KINDS` by default.

    Raises:
        ConfigError: No such kind.
    """
    kinds = KINDS if kinds is None else kinds
    if kind not in kinds:
        raise ConfigError(unknown_choice("kind of study", kind, kinds))
    return _loaded(kinds[kind])


def settings_of(kind: str) -> type[StudyConfig]:
    """Model of the files of a kind of study, a key of `KINDS`."""
    return _loaded(KINDS[kind]).settings


def package_versions(study: Study) -> dict[str, str]:
    """Versions of the packages that a study needs beside those of the program.

    Raises:
        ConfigError: One of them is not installed.
    """
    for package in study.packages:
        if importlib.util.find_spec(package) is None:
            extra = EXTRAS.get(package, package)
            msg = (
                f"study '{study.config.kind}' needs the package {package}: pip install 'magicsim-experiments[{extra}]'"
            )
            raise ConfigError(msg)
    return {name: importlib.metadata.version(name) for name in study.packages}


def _loaded(home: str) -> type[Study]:
    module, _, name = home.partition(":")
    return cast("type[Study]", getattr(importlib.import_module(module), name))
