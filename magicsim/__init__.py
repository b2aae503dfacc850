"""magicsim: a physics-based simulator of the mini-MagicTac see-through touch sensor.

The functions below are loaded when they are first used, so that importing the package stays light.
"""

import importlib
from typing import TYPE_CHECKING

from magicsim.moved import find_moved

if TYPE_CHECKING:
    from magicsim.dataset.generate import generate_dataset
    from magicsim.dataset.recipes.recipe import load_recipe
    from magicsim.deform.indentation.durometer import durometer
    from magicsim.deform.indentation.press import press
    from magicsim.detectors.offline import detect_sources
    from magicsim.evaluation.evaluate import evaluate_suite
    from magicsim.evaluation.suite import load_suite
    from magicsim.judge.profile_fit import calibrate
    from magicsim.scenes.scene import load_scene
    from magicsim.simulation.plan import plan_scene
    from magicsim.simulation.still import render_still
    from magicsim.simulation.stream import simulate
    from magicsim.sweep.comparison import run_sweep
    from magicsim.sweep.sweep_file import load_sweep

__version__ = "0.1.0"
__all__ = [
    "calibrate",
    "detect_sources",
    "durometer",
    "evaluate_suite",
    "generate_dataset",
    "load_recipe",
    "load_scene",
    "load_suite",
    "load_sweep",
    "plan_scene",
    "press",
    "render_still",
    "run_sweep",
    "simulate",
]

_HOMES = {
    "calibrate": "magicsim.judge.profile_fit",
    "detect_sources": "magicsim.detectors.offline",
    "durometer": "magicsim.deform.indentation.durometer",
    "evaluate_suite": "magicsim.evaluation.evaluate",
    "generate_dataset": "magicsim.dataset.generate",
    "load_recipe": "magicsim.dataset.recipes.recipe",
    "load_scene": "magicsim.scenes.scene",
    "load_suite": "magicsim.evaluation.suite",
    "load_sweep": "magicsim.sweep.sweep_file",
    "plan_scene": "magicsim.simulation.plan",
    "press": "magicsim.deform.indentation.press",
    "render_still": "magicsim.simulation.still",
    "run_sweep": "magicsim.sweep.comparison",
    "simulate": "magicsim.simulation.stream",
}

find_moved()


def __getattr__(name: str) -> object:
    """Loads a public function from its module."""
    if name not in _HOMES:
        msg = f"module 'magicsim' has no attribute '{name}'"
        raise AttributeError(msg)
    function = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = function
    return function


def __dir__() -> list[str]:
    """Names of the package, the functions not yet loaded included."""
    return sorted({*globals(), *__all__})
