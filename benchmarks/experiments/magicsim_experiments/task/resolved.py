"""What the episodes of a run depend on: its settings with the content of every file that they name."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from magicsim.config.models import Config
from magicsim.config.named_files import file_hashes
from magicsim.scenes.scene import SceneConfig
from magicsim_experiments.task.item import Item


def resolved(
    config: Config, *, items: Mapping[str, Item], scenes: Mapping[str, SceneConfig], profile: Mapping[str, Any]
) -> dict[str, Any]:
    """Settings of a task, and under `resolved` what their names stand for.

    Args:
        config: As it was asked for.
        items: By name.
        scenes: Fingers and item, by the item's name; they differ in what the item says alone.
        profile: What reads the frames; empty where the settings say it by themselves.

    Returns:
        Plain values, as TOML and JSON take them.

    Raises:
        OSError: A file cannot be read.
    """
    fingers = next(iter(scenes.values())).model_dump(mode="json", exclude={"object": True, "contact": {"friction"}})
    files = {name: file_hashes(scene.model_dump(mode="json")) for name, scene in scenes.items()}
    content = {
        "profile": dict(profile),
        "items": {name: item.model_dump(mode="json") for name, item in items.items()},
        "fingers": fingers,
        "sha256": {name: found for name, found in files.items() if found},
    }
    return plain_values(config.model_dump(mode="json") | {"resolved": content})


def resolved_scene(scene: SceneConfig) -> dict[str, Any]:
    """A scene with everything in place, and the SHA-256 of every file that it names.

    Args:
        scene: The scene.

    Raises:
        OSError: A file cannot be read.
    """
    values = scene.model_dump(mode="json")
    found = file_hashes(values)
    return {"scene": values} | ({"sha256": found} if found else {})


def plain_values(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as TOML and JSON take them: without keys that have no value."""
    plain: dict[str, Any] = _without_none(settings)
    return plain


def digest_of(settings: Mapping[str, Any]) -> str:
    """SHA-256 of a run's settings, so that a folder is not continued with another task."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()


def _without_none(value: Any) -> Any:  # noqa: ANN401 - plain values of any kind
    """Tables without keys that have no value, which TOML cannot say."""
    if isinstance(value, Mapping):
        return {key: _without_none(each) for key, each in value.items() if each is not None}
    return [_without_none(each) for each in value] if isinstance(value, list | tuple) else value
