"""A few of the cases of `benchmarks/fuzz_commands.py`."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[3] / "benchmarks" / "fuzz_commands.py"


@pytest.mark.slow
def test_commands_with_extreme_settings_end_with_a_result_or_one_line():
    done = subprocess.run(
        [sys.executable, SCRIPT, "--count", "24", "--seed", "5"], capture_output=True, text=True, check=False
    )
    report = json.loads(done.stdout)
    assert report["failed"] == []
    assert done.returncode == 0
    assert report["cases"] == 24
