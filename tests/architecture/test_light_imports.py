"""What an import costs: heavy packages are loaded only by what needs them."""

import subprocess
import sys

import pytest

HEAVY = {
    "mitsuba",
    "drjit",
    "numba",
    "scipy",
    "matplotlib",
    "trimesh",
    "manifold3d",
    "pyarrow",
    "cv2",
    "PIL",
    "jinja2",
    "sklearn",
    "gymnasium",
    "optuna",
}


def loaded_by(statement: str) -> set[str]:
    """Roots of all modules that a statement loads, in a fresh interpreter."""
    code = f"import sys\n{statement}\nsys.stderr.write(' '.join({{name.split('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    return set(done.stderr.split())


@pytest.mark.parametrize(
    "packages",
    [
        "magicsim",
        "magicsim.geometry, magicsim.deform, magicsim.scenes, magicsim.light, magicsim.report, magicsim.robot",
        "magicsim.live",
        "magicsim.errors, magicsim.config",
    ],
)
def test_package_loads_nothing_heavy(packages: str):
    assert not loaded_by(f"import {packages}") & HEAVY


def test_package_itself_needs_the_standard_library_alone():
    extra = {name for name in loaded_by("import magicsim") - loaded_by("pass") if name not in sys.stdlib_module_names}
    assert extra == {"magicsim"}


def test_detectors_load_opencv_and_numpy_and_nothing_else_that_is_heavy():
    loaded = loaded_by("import magicsim.detectors")
    assert {"numpy", "cv2"} <= loaded
    assert not loaded & (HEAVY - {"cv2"})
    assert "pydantic" not in loaded


def test_command_line_loads_neither_heavy_packages_nor_the_configuration_models():
    loaded = loaded_by("import magicsim.cli")
    assert not loaded & (HEAVY | {"numpy", "pydantic"})


def test_help_loads_nothing_heavy():
    statement = (
        "import magicsim.cli\nsys.argv = ['magicsim', '--help']\n"
        "try:\n    magicsim.cli.main()\nexcept SystemExit:\n    pass"
    )
    assert not loaded_by(statement) & (HEAVY | {"numpy", "pydantic"})


@pytest.mark.parametrize("command", ["['plan', 'demo']", "['schema', 'scene']"])
def test_commands_that_neither_solve_nor_render_load_neither_solver_nor_renderer(command: str):
    statement = (
        f"import magicsim.cli\nsys.argv = ['magicsim', *{command}]\n"
        "try:\n    magicsim.cli.main()\nexcept SystemExit:\n    pass"
    )
    assert not loaded_by(statement) & {"mitsuba", "drjit", "numba", "scipy", "matplotlib", "pyarrow"}


def test_press_does_without_the_renderer():
    assert not loaded_by("import magicsim.deform.indentation.press") & {
        "mitsuba",
        "drjit",
        "matplotlib",
        "pyarrow",
        "cv2",
    }
