"""What `magicsim live` is given: a scene, or a design that takes the object and the rig of a standard scene."""

from collections.abc import Sequence
from pathlib import Path

from magicsim.config.documents import read_toml
from magicsim.config.models import apply_overrides, load_preset, validate
from magicsim.config.presets import find_preset, preset_names
from magicsim.errors import PresetError, unknown_choice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import SceneConfig, load_scene

STAGE = "grip"
"""Scene that lends a design its rig, its object and the friction between them."""


def find_subject(
    name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None, object: str | None = None
) -> SceneConfig:
    """The scene of a window.

    Args:
        name: Preset or TOML file of a scene or of a design.
        overrides: `dotted.key=value` settings of the scene; `design.` and `rig.` reach into those files.
        seed: Seed instead of the scene's.
        object: An object instead of the scene's: preset, file, or `KIND:key=value,...`.

    Raises:
        PresetError: No such scene or design.
        ConfigError: The content is not acceptable.
    """
    if _is_design(name):
        design = load_preset(ElastomerDesign, "design", name)
        data = load_scene(STAGE, seed=seed).model_dump()
        data["design"] = design.model_dump()
        scene = validate(SceneConfig, apply_overrides(data, list(overrides)), source=str(name))
    else:
        scene = load_scene(name, overrides, seed=seed)
    return scene if object is None else scene.model_copy(update={"object": parse_object(object)})


def _is_design(name: str | Path) -> bool:
    """Whether a name or file is a design and not a scene.

    Raises:
        PresetError: Neither.
    """
    text = str(name)
    if text in preset_names("scene"):
        return False
    if text in preset_names("design"):
        return True
    if not (text.endswith(".toml") or "/" in text):
        choices = sorted({*preset_names("scene"), *preset_names("design")})
        raise PresetError(unknown_choice("scene or design", text, choices))
    return "keyframes" not in read_toml(find_preset("scene", name))
