"""The plain NumPy statement of the published equations, which stands beside the benchmark that times it."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType


def _load() -> ModuleType:
    path = Path(__file__).parents[3] / "benchmarks" / "plain_detectors.py"
    spec = importlib.util.spec_from_file_location("plain_detectors", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up by name
    spec.loader.exec_module(module)
    return module


plain = _load()
