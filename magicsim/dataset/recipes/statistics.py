"""What a recipe will give, known without simulating anything."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from magicsim.dataset.layout import split_of
from magicsim.dataset.recipes.draw import DrawnEpisode
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.frame_class import classify_frame
from magicsim.scenes.timeline import FrameState, timeline


def recipe_statistics(recipe: Recipe, episodes: Sequence[DrawnEpisode]) -> dict[str, Any]:
    """Counts of episodes and frames by what they show, and the spread of every drawn value.

    The class of a frame supposes that what is pressed touches.
    """
    frames: Counter[str] = Counter()
    for episode in episodes:
        frames["Reference"] += recipe.references
        frames.update(_class(state) for state in timeline(episode.scene))
    drawn: dict[str, list[float]] = {}
    for episode in episodes:
        for name, value in episode.values.items():
            drawn.setdefault(name, []).append(value)
    kinds = [episode.scene.object.kind if episode.scene.object is not None else "none" for episode in episodes]
    return {
        "episodes": len(episodes),
        "frames": sum(frames.values()),
        "sensors": len({episode.sensor for episode in episodes}),
        "frames_by_class": _sorted(frames),
        "episodes_by_path": _sorted(Counter(episode.path_kind for episode in episodes)),
        "episodes_by_object": _sorted(Counter(kinds)),
        "episodes_by_split": _sorted(Counter(split_of(recipe, episode.index) for episode in episodes)),
        "drawn": {name: _spread(drawn[name]) for name in sorted(drawn)},
    }


def _class(state: FrameState) -> str:
    touching = state.gap_mm is not None and state.gap_mm < 0
    found = classify_frame(
        gap_mm=state.gap_mm, force_n=1.0 if touching else 0.0, light_on=state.flashlight, is_reference=False
    )
    return str(found) if found is not None else "between"


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))


def _spread(values: list[float]) -> dict[str, float]:
    low, middle, high = np.quantile(values, [0, 0.5, 1]).round(6).tolist()
    return {"count": len(values), "min": low, "median": middle, "max": high}
