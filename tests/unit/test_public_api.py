import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import magicsim
from magicsim.deform.indentation.press import press
from magicsim.detectors.offline import detect_sources
from magicsim.scenes.scene import load_scene
from magicsim.simulation.plan import plan_scene


def test_each_public_function_is_that_of_its_own_module():
    assert magicsim.press is press
    assert magicsim.detect is detect_sources
    assert magicsim.plan_scene is plan_scene
    assert magicsim.load_scene is load_scene


def test_public_names_are_listed_before_they_are_loaded():
    assert set(magicsim.__all__) <= set(dir(magicsim))


def test_no_public_name_is_that_of_a_module_which_an_import_would_put_in_its_place():
    assert not set(magicsim.__all__) & {module.name for module in pkgutil.iter_modules(magicsim.__path__)}


def test_no_two_public_names_are_one_function():
    assert len({id(getattr(magicsim, name)) for name in magicsim.__all__}) == len(magicsim.__all__)


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'magicsim' has no attribute 'sinulate'"):
        _ = magicsim.sinulate
    assert not hasattr(magicsim, "_hidden")


def test_public_functions_are_loaded_one_at_a_time():
    code = "import sys, magicsim; magicsim.plan_scene; print({'mitsuba', 'numba'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_reference_lists_every_public_name_and_none_of_an_inner_module():
    text = (Path(__file__).parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
    assert not {name for name in magicsim.__all__ if f":: magicsim.{name}\n" not in text}
    homes = {"magicsim", "magicsim.robot", "magicsim.detectors", "magicsim.dataset"}
    assert {name.rpartition(".")[0] for name in re.findall(r":: (magicsim[\w.]+)", text)} - {"magicsim"} <= homes
