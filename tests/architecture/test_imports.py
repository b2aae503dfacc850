"""Who may import whom, and what an import costs; most rules are the contracts of `pyproject.toml`."""

import json
import re
import subprocess
import sys
import tomllib
from functools import cache

import grimp
from importlinter.api import use_cases

from .source import PACKAGE, ROOT

MOST_PARTS, MOST_FILES, MOST_FLAT = 4, 20, 9
"""Parts of one layer, files of one folder, and modules beside the folders."""
PARTS = ("errors", "config", "geometry", "deform", "scenes", "light", "report", "robot", "live")
RENDERER = {"mitsuba", "drjit"}
SLOW = RENDERER | {"numba", "scipy", "matplotlib", "pyarrow"}
HEAVY = SLOW | {"trimesh", "manifold3d", "cv2", "PIL", "jinja2", "sklearn", "gymnasium", "optuna"}
CALL = "try:\n    magicsim.cli.main()\nexcept SystemExit:\n    pass"


@cache
def graph() -> grimp.ImportGraph:
    """Every import of the package, inside functions too; those for typing alone are left out."""
    return grimp.build_graph(
        "magicsim", include_external_packages=True, exclude_type_checking_imports=True, cache_dir=None
    )


def loaded_after(*statements: str) -> list[set[str]]:
    """Roots of all modules that are there after each of some statements, which one fresh interpreter runs in turn."""
    code = "import json, sys\nloaded = []\n"
    for statement in statements:
        code += f"{statement}\nloaded.append(sorted({{name.split('.')[0] for name in sys.modules}}))\n"
    code += "sys.stderr.write('\\n' + json.dumps(loaded))"  # after what a slow machine says while it waits
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    return [set(names) for names in json.loads(done.stderr.splitlines()[-1])]


def contracts() -> list[dict]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]


def test_contracts_of_imports_are_kept(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert use_cases.lint_imports(config_filename="pyproject.toml", cache_dir=None), capsys.readouterr().out


def test_detectors_import_numpy_opencv_and_the_standard_library_alone():
    modules = graph().find_descendants("magicsim.detectors")
    found = set().union(*(graph().find_modules_directly_imported_by(module) for module in modules))
    roots = {name.split(".")[0] for name in found}
    assert {"numpy", "cv2"} <= roots
    assert roots <= {"numpy", "cv2", "magicsim"} | set(sys.stdlib_module_names)


def test_no_module_is_imported_in_a_circle():
    own = {module for module in graph().modules if module.split(".")[0] == "magicsim"}
    needs = {module: graph().find_modules_directly_imported_by(module) & own - {module} for module in own}
    while leaves := [module for module in needs if not needs[module] & set(needs)]:
        for module in leaves:
            del needs[module]
    assert not needs


def test_page_lists_the_layers_and_no_layer_or_folder_is_a_crowd():
    layers = next(each["layers"] for each in contracts() if each["type"] == "layers")
    parts = [set(re.findall(r"\w+", layer)) for layer in layers if layer != "__main__"]
    page = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = re.findall(r"^\| \w+ \| ((?:`\w+`(?:, )?)+) \|", page, re.MULTILINE)
    assert [set(re.findall(r"\w+", row)) for row in rows] == parts
    assert max(map(len, parts)) <= MOST_PARTS
    folders = [folder for folder in (PACKAGE, *PACKAGE.rglob("*")) if folder.is_dir() and folder.name != "__pycache__"]
    counts = {folder.name: len(list(folder.glob("*.py"))) for folder in folders}
    assert counts.pop(PACKAGE.name) <= MOST_FLAT
    assert not {name: count for name, count in counts.items() if count > MOST_FILES}


def test_imports_and_commands_load_nothing_heavy_before_they_need_it():
    statements = [
        "", "import magicsim", "import magicsim.cli", f"sys.argv = ['magicsim', '--help']\n{CALL}",
        "import " + ", ".join(f"magicsim.{part}" for part in PARTS),
        f"sys.argv = ['magicsim', 'schema', 'scene']\n{CALL}", f"sys.argv = ['magicsim', 'plan', 'demo']\n{CALL}",
    ]  # fmt: skip
    bare, package, command, shown, parts, schema, plan = loaded_after(*statements)
    assert {name for name in package - bare if name not in sys.stdlib_module_names} == {"magicsim"}
    assert not (command | shown) & (HEAVY | {"numpy", "pydantic"})
    assert not parts & HEAVY
    assert not (schema | plan) & SLOW


def test_press_and_page_do_without_the_renderer():
    page = "import magicsim.report.page\nassert 'matplotlib.pyplot' not in sys.modules"
    press, both = loaded_after("import magicsim.deform.indentation.press", page)
    assert not press & (RENDERER | {"matplotlib", "pyarrow", "cv2"})
    assert not both & RENDERER


def test_detectors_load_opencv_and_numpy_and_nothing_else():
    bare, loaded = loaded_after("", "import magicsim.detectors")
    outside = {name for name in loaded - bare if name not in sys.stdlib_module_names}
    assert outside - {"magicsim"} >= {"numpy", "cv2"}
    assert outside <= {"numpy", "cv2", "magicsim"}


def test_intervals_and_their_level_are_made_in_one_room():
    makes = re.compile(r"\b(?:binomtest|gammaincinv|permutation_test|proportion_ci|CONFIDENCE)\b|0\.025, *0\.975")
    files = [path for folder in (PACKAGE, ROOT / "benchmarks") for path in folder.rglob("*.py")]
    found = {str(path.relative_to(ROOT)) for path in files if makes.search(path.read_text("utf-8"))}
    assert found == {"magicsim/judge/measures.py"}
