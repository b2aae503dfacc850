import subprocess
import sys

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
        "calibrate", "detect_sources", "durometer", "evaluate_suite", "generate_dataset", "load_recipe", "load_scene",
        "load_suite", "load_sweep", "plan_scene", "press", "render_still", "run_sweep", "simulate",
    }  # fmt: skip
    assert set(magicsim.__all__) <= set(dir(magicsim))


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'magicsim' has no attribute 'sinulate'"):
        _ = magicsim.sinulate
    assert not hasattr(magicsim, "_hidden")


@pytest.mark.parametrize(
    "before",
    ["", "import magicsim.simulation.stream", "import magicsim.judge.main_job", "from magicsim import simulate"],
)
def test_simulate_is_the_function_whatever_was_imported_before(before: str):
    code = f"{before}\nfrom magicsim import simulate\nimport magicsim.simulation.stream as stream\n"
    code += "print(callable(simulate), simulate is stream.simulate, simulate.__module__, stream.Sensor.__name__)"
    assert run(code) == "True True magicsim.simulation.stream Sensor"


def test_public_functions_are_loaded_one_at_a_time():
    code = "import sys, magicsim; magicsim.plan_scene; print('mitsuba' in sys.modules, 'numba' in sys.modules)"
    assert run(code) == "False False"
