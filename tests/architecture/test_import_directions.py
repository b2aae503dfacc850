"""Who may import whom, held by parsing every module."""

import ast
import re
import sys

import pytest

from .source import PACKAGE, ROOT, imports, modules, top_level_imports

LAYERS = {
    "words": {"conventions", "names", "arrays"},
    "vocabulary": {"errors", "frame_class", "waiting"},
    "files": {"config", "folder", "notebook"},
    "block": {"sampling", "geometry"},
    "physics": {"camera", "deform", "scenes"},
    "light": {"light"},
    "sensor": {"simulation", "workers"},
    "judgement": {"judge"},
    "products": {"report", "fit", "dataset", "robot"},
    "comparisons": {"evaluation", "sweep", "bench", "learn"},
    "experiments": {"live", "study", "task"},
    "entry": {"cli", "__main__"},
}
"""Layers from the leaf upwards, as in `docs/architecture.md`; a part imports parts below it and of its own layer."""
BELOW_JUDGEMENT = {part for name in list(LAYERS)[: list(LAYERS).index("judgement")] for part in LAYERS[name]}
MOST_PARTS, MOST_FILES, MOST_FLAT = 4, 20, 8
"""Parts of one layer, files of one folder, and modules beside the folders."""
LEAF_OF_DETECTORS = {
    "magicsim.config",
    "magicsim.config.documents",
    "magicsim.config.presets",
    "magicsim.conventions",
    "magicsim.errors",
    "magicsim.frame_class",
    "magicsim.names",
    "magicsim.waiting",
}
RENDERER = {"mitsuba", "drjit"}


def part_of(module: str) -> str:
    """First name below the package, empty for the package itself."""
    return module.partition(".")[2].partition(".")[0]


def own_imports(module: str) -> set[str]:
    return {name for name in imports(modules()[module]) if name.split(".")[0] == "magicsim" and name != "magicsim"}


def layer_of(part: str) -> int:
    return next(number for number, layer in enumerate(LAYERS.values()) if part in layer)


def inside(*parts: str) -> list[str]:
    return [module for module in modules() if part_of(module) in parts]


def test_every_part_of_the_package_has_a_layer():
    parts = {part_of(module) for module in modules()} - {"", "detectors"}
    assert parts <= set().union(*LAYERS.values())


@pytest.mark.parametrize("module", [m for m in modules() if part_of(m) not in {"", "detectors"}])
def test_module_imports_only_from_its_own_layer_and_those_below(module: str):
    own = layer_of(part_of(module))
    above = {name for name in own_imports(module) if part_of(name) != "detectors" and layer_of(part_of(name)) > own}
    assert not above


def test_page_lists_the_layers_and_their_parts():
    page = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = re.findall(r"^\| (\w+) \| ((?:`\w+`(?:, )?)+) \|", page, re.MULTILINE)
    listed = {name: set(re.findall(r"\w+", parts)) for name, parts in rows}
    assert listed == {name: parts - {"__main__"} for name, parts in LAYERS.items()}
    assert [name for name, _ in rows] == list(LAYERS)[::-1]


def test_no_layer_is_a_crowd():
    assert max(len(layer - {"__main__"}) for layer in LAYERS.values()) <= MOST_PARTS


def test_no_folder_is_a_crowd():
    folders = [folder for folder in (PACKAGE, *PACKAGE.rglob("*")) if folder.is_dir() and folder.name != "__pycache__"]
    counts = {folder.name: sum(path.is_file() for path in folder.iterdir()) for folder in folders}
    assert counts.pop(PACKAGE.name) - 1 <= MOST_FLAT  # py.typed is no module
    assert not {name: count for name, count in counts.items() if count > MOST_FILES}


@pytest.mark.parametrize("module", inside("detectors"))
def test_detectors_import_only_the_leaf_numpy_opencv_and_the_standard_library(module: str):
    assert {name for name in own_imports(module) if part_of(name) != "detectors"} <= LEAF_OF_DETECTORS
    roots = {name.split(".")[0] for name in imports(modules()[module])}
    assert roots <= {"numpy", "cv2", "magicsim"} | set(sys.stdlib_module_names)


@pytest.mark.parametrize("module", inside(*BELOW_JUDGEMENT))
def test_nothing_below_judge_imports_detectors(module: str):
    assert "detectors" not in {part_of(name) for name in own_imports(module)}


@pytest.mark.parametrize("module", sorted(LEAF_OF_DETECTORS))
def test_leaf_needs_the_standard_library_alone(module: str):
    roots = {name.split(".")[0] for name in top_level_imports(modules()[module])}
    assert roots <= {"magicsim"} | set(sys.stdlib_module_names)


@pytest.mark.parametrize("module", inside("geometry"))
def test_geometry_knows_neither_deformation_nor_scenes(module: str):
    assert not {part_of(name) for name in own_imports(module)} & {"deform", "scenes", "light"}


@pytest.mark.parametrize("module", [m for m in modules() if part_of(m) != "light"])
def test_renderer_is_imported_inside_light_alone(module: str):
    assert not {name.split(".")[0] for name in imports(modules()[module])} & RENDERER


def test_variant_is_set_in_exactly_one_function():
    places = [
        (module, function.name)
        for module, tree in modules().items()
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "set_variant"
    ]
    assert places == [("magicsim.light.variant", "activate_variant")]


def test_nothing_is_imported_in_a_circle_inside_functions_neither():
    graph = {module: imports(tree) & set(modules()) - {module} for module, tree in modules().items()}
    while leaves := [module for module, needs in graph.items() if not needs & set(graph)]:
        for module in leaves:
            del graph[module]
    assert not graph
