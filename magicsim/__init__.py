"""magicsim: a physics-based simulator of the mini-MagicTac see-through touch sensor.

The functions below are loaded when they are first used, so that importing the package stays light.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.dataset.generate import generate_dataset
    from magicsim.dataset.recipe import load_recipe
    from magicsim.deform.durometer import durometer
    from magicsim.deform.press import press
    from magicsim.deform.press_curve import press_curve
    from magicsim.detector_fit import calibrate
    from magicsim.detectors.offline import detect_sources
    from magicsim.evaluate.run import evaluate_suite
    from magicsim.evaluate.suite import load_suite
    from magicsim.plan import plan_scene
    from magicsim.scenes.scene import load_scene
    from magicsim.simulation import simulate
    from magicsim.still import render_still
    from magicsim.sweep.run import run_sweep
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
    "press_curve",
    "render_still",
    "run_sweep",
    "simulate",
]

_HOMES = {
    "calibrate": "magicsim.detector_fit",
    "detect_sources": "magicsim.detectors.offline",
    "durometer": "magicsim.deform.durometer",
    "evaluate_suite": "magicsim.evaluate.run",
    "generate_dataset": "magicsim.dataset.generate",
    "load_recipe": "magicsim.dataset.recipe",
    "load_scene": "magicsim.scenes.scene",
    "load_suite": "magicsim.evaluate.suite",
    "load_sweep": "magicsim.sweep.sweep_file",
    "plan_scene": "magicsim.plan",
    "press": "magicsim.deform.press",
    "press_curve": "magicsim.deform.press_curve",
    "render_still": "magicsim.still",
    "run_sweep": "magicsim.sweep.run",
    "simulate": "magicsim.simulation",
}


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
