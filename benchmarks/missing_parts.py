"""What a machine without PARDISO or without LLVM pays: times as long for the same work, in one run.

python benchmarks/missing_parts.py        # some minutes

Each ratio is of medians over `TURNS` runs of either, which take turns. Without LLVM Mitsuba's scalar variant renders,
which has no cached fluence: the path tracer makes the picture, and it is noisier too.
"""

import json
import os
import statistics
import subprocess
import sys
import time

TURNS = 3
SOLVE = """
import sys, time
from magicsim.deform.linear import factorise
if sys.argv[1] == "superlu":
    factorise.has_pardiso = lambda: False
from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import press
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
block = load_preset(ElastomerDesign, "design", "mini-magictac")
print(press(block, parse_object("sphere:radius_mm=4"), depth_mm=1.0).seconds)
"""
RENDER = ("render", "near", "--estimator", "path", "--samples", "4", "--json")


def solve_s(library: str) -> float:
    """Seconds of one press with a library."""
    done = subprocess.run([sys.executable, "-c", SOLVE, library], capture_output=True, text=True, check=True)
    return float(done.stdout)


def render_s(variant: str) -> float:
    """Seconds of one image by the path tracer with a variant of Mitsuba."""
    command = [sys.executable, "-m", "magicsim", *RENDER]
    done = subprocess.run(
        command, capture_output=True, text=True, check=True, env=os.environ | {"MAGICSIM_VARIANT": variant}
    )
    return float(json.loads(done.stdout)["seconds"])


if __name__ == "__main__":
    begin = time.perf_counter()
    solves = [(solve_s("pardiso"), solve_s("superlu")) for _ in range(TURNS)]
    images = [(render_s("llvm_ad_rgb"), render_s("scalar_rgb")) for _ in range(TURNS)]
    found = {
        "superlu_over_pardiso": statistics.median(b for _, b in solves) / statistics.median(a for a, _ in solves),
        "scalar_over_llvm": statistics.median(b for _, b in images) / statistics.median(a for a, _ in images),
        "solve_s": solves, "image_s": images, "seconds": time.perf_counter() - begin,
    }  # fmt: skip
    print(json.dumps(found, indent=2))
