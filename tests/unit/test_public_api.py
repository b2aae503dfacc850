import subprocess
import sys
from pathlib import Path

import pytest

import magicsim
from magicsim.deform.indentation.press import press
from magicsim.detectors.offline import detect_sources
from magicsim.scenes.scene import load_scene
from magicsim.simulation.plan import plan_scene


def run(code: str) -> str:
    command = [sys.executable, "-W", "error", "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def test_each_public_function_is_that_of_its_own_module():
    assert magicsim.press is press
    assert magicsim.detect_sources is detect_sources
    assert magicsim.plan_scene is plan_scene
    assert magicsim.load_scene is load_scene


def test_public_names_are_listed_before_they_are_loaded():
    assert set(magicsim.__all__) == {
        "Sensor", "calibrate", "calibrate_camera", "detect", "detect_sources", "durometer", "evaluate",
        "evaluate_suite", "export_design", "fit_constants", "generate_dataset", "judge_episode", "live_sensor",
        "load_design", "load_object", "load_profile", "load_recipe", "load_rig", "load_scene", "load_suite",
        "load_sweep", "make_dataset", "plan_scene", "press", "press_curve", "render", "render_still", "run_scene",
        "run_sweep", "simulate",
    }  # fmt: skip
    assert {*magicsim.__all__, "report_episode"} == set(magicsim.HOMES)
    assert set(magicsim.__all__) <= set(dir(magicsim))


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'magicsim' has no attribute 'sinulate'"):
        _ = magicsim.sinulate
    assert not hasattr(magicsim, "_hidden")


@pytest.mark.parametrize(
    "before",
    ["", "import magicsim.simulation.stream", "import magicsim.simulation.main_job", "from magicsim import simulate"],
)
def test_simulate_is_the_function_whatever_was_imported_before(before: str):
    code = f"{before}\nfrom magicsim import simulate\nimport magicsim.simulation.stream as stream\n"
    code += "print(callable(simulate), simulate is stream.simulate, simulate.__module__, stream.Sensor.__name__)"
    assert run(code) == "True True magicsim.simulation.stream Sensor"


def test_public_functions_are_loaded_one_at_a_time():
    code = "import sys, magicsim; magicsim.plan_scene; print('mitsuba' in sys.modules, 'numba' in sys.modules)"
    assert run(code) == "False False"


def test_other_names_of_a_function_are_that_function():
    assert magicsim.detect is magicsim.detect_sources
    assert magicsim.make_dataset is magicsim.generate_dataset


def test_reference_lists_every_public_name():
    text = (Path(__file__).parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
    others = {"detect_sources", "generate_dataset"}  # named beside the functions that they are
    assert not {name for name in set(magicsim.__all__) - others if f":: magicsim.{name}\n" not in text}
    assert all(f"`{name}`" in text for name in others)
