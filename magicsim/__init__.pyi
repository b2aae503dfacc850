from magicsim.camera.projection import calibrate_camera
from magicsim.dataset.generate import generate_dataset as make_dataset
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.deform.indentation.bearing import Bearing, press_limits
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

__all__ = [
    "Bearing", "DurometerResult", "ElastomerDesign", "Episode", "FrameTruth", "PressCurve", "PressResult", "Rendering",
    "Rig", "SceneConfig", "ScenePlan", "Sensor", "SimulatedFrame", "calibrate", "calibrate_camera", "detect",
    "durometer", "evaluate", "evaluate_suite", "export_design", "fit_constants", "judge_episode", "live_sensor",
    "load_design", "load_object", "load_profile", "load_recipe", "load_rig", "load_scene", "load_suite", "load_sweep",
    "make_dataset", "plan_scene", "press", "press_curve", "press_limits", "relight", "render", "render_still",
    "run_scene", "run_sweep", "simulate",
]  # fmt: skip
__version__: str
