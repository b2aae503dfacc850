"""magicsim: a physics-based simulator of the mini-MagicTac see-through touch sensor.

The names below are loaded when they are first used, so that importing the package stays light.
"""

import os
from typing import TYPE_CHECKING

from magicsim.conventions import MAX_PIXELS
from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.camera.calibration import calibrate_camera
    from magicsim.dataset.generate import generate_dataset as make_dataset
    from magicsim.dataset.recipes.recipe import load_recipe
    from magicsim.deform.indentation.durometer import DurometerResult, durometer
    from magicsim.deform.indentation.path import PressResult
    from magicsim.deform.indentation.press import PressCurve, press, press_curve
    from magicsim.detectors.offline import detect_sources as detect
    from magicsim.detectors.profile import load_profile
    from magicsim.evaluation.evaluate import evaluate, evaluate_suite
    from magicsim.evaluation.suite import load_suite
    from magicsim.fit.fitting import fit_constants
    from magicsim.geometry.design import ElastomerDesign, load_design
    from magicsim.geometry.files.export import export_design
    from magicsim.geometry.objects.kinds import load_object
    from magicsim.judge.profile_fit import calibrate
    from magicsim.judge.verdicts import judge as judge_episode
    from magicsim.light.relight import relight
    from magicsim.robot.live import live_sensor
    from magicsim.scenes.rig import Rig, load_rig
    from magicsim.scenes.scene import SceneConfig, load_scene
    from magicsim.simulation.episode import Episode, FrameTruth, SimulatedFrame
    from magicsim.simulation.main_job import run_scene
    from magicsim.simulation.plan import ScenePlan, plan_scene
    from magicsim.simulation.sensor import Sensor
    from magicsim.simulation.still import Rendering, render, render_still
    from magicsim.simulation.stream import simulate
    from magicsim.sweep.comparison import run_sweep
    from magicsim.sweep.sweep_file import load_sweep

os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MAX_PIXELS))  # OpenCV reads it when it is loaded

__version__ = "0.1.0"
__all__ = [
    "DurometerResult",
    "ElastomerDesign",
    "Episode",
    "FrameTruth",
    "PressCurve",
    "PressResult",
    "Rendering",
    "Rig",
    "SceneConfig",
    "ScenePlan",
    "Sensor",
    "SimulatedFrame",
    "calibrate",
    "calibrate_camera",
    "detect",
    "durometer",
    "evaluate",
    "evaluate_suite",
    "export_design",
    "fit_constants",
    "judge_episode",
    "live_sensor",
    "load_design",
    "load_object",
    "load_profile",
    "load_recipe",
    "load_rig",
    "load_scene",
    "load_suite",
    "load_sweep",
    "make_dataset",
    "plan_scene",
    "press",
    "press_curve",
    "relight",
    "render",
    "render_still",
    "run_scene",
    "run_sweep",
    "simulate",
]

HOMES = {
    "DurometerResult": "magicsim.deform.indentation.durometer",
    "ElastomerDesign": "magicsim.geometry.design",
    "Episode": "magicsim.simulation.episode",
    "FrameTruth": "magicsim.simulation.episode",
    "PressCurve": "magicsim.deform.indentation.press",
    "PressResult": "magicsim.deform.indentation.path",
    "Rendering": "magicsim.simulation.still",
    "Rig": "magicsim.scenes.rig",
    "SceneConfig": "magicsim.scenes.scene",
    "ScenePlan": "magicsim.simulation.plan",
    "Sensor": "magicsim.simulation.sensor",
    "SimulatedFrame": "magicsim.simulation.episode",
    "calibrate": "magicsim.judge.profile_fit",
    "calibrate_camera": "magicsim.camera.calibration",
    "detect": "magicsim.detectors.offline:detect_sources",
    "durometer": "magicsim.deform.indentation.durometer",
    "evaluate": "magicsim.evaluation.evaluate",
    "evaluate_suite": "magicsim.evaluation.evaluate",
    "export_design": "magicsim.geometry.files.export",
    "fit_constants": "magicsim.fit.fitting",
    "judge_episode": "magicsim.judge.verdicts:judge",
    "live_sensor": "magicsim.robot.live",
    "load_design": "magicsim.geometry.design",
    "load_object": "magicsim.geometry.objects.kinds",
    "load_profile": "magicsim.detectors.profile",
    "load_recipe": "magicsim.dataset.recipes.recipe",
    "load_rig": "magicsim.scenes.rig",
    "load_scene": "magicsim.scenes.scene",
    "load_suite": "magicsim.evaluation.suite",
    "load_sweep": "magicsim.sweep.sweep_file",
    "make_dataset": "magicsim.dataset.generate:generate_dataset",
    "plan_scene": "magicsim.simulation.plan",
    "press": "magicsim.deform.indentation.press",
    "press_curve": "magicsim.deform.indentation.press",
    "relight": "magicsim.light.relight",
    "render": "magicsim.simulation.still",
    "render_still": "magicsim.simulation.still",
    "report_episode": "magicsim.report.episode_report",
    "run_scene": "magicsim.simulation.main_job",
    "run_sweep": "magicsim.sweep.comparison",
    "simulate": "magicsim.simulation.stream",
}
"""Where each public name is at home, and `report_episode`, which `run_scene` calls although it stands above it."""

__getattr__, __dir__ = lazy_names(__name__, HOMES)
