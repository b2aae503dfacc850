"""What a machine without PARDISO pays: processor time of the same press with SuperLU, in units of PARDISO's.

python benchmarks/missing_parts.py        # a minute
"""

import json
import statistics
import subprocess
import sys

TURNS = 3
SOLVE = """
import sys, time
from magicsim.deform.solve import factorise
if sys.argv[1] == "SuperLU":
    factorise.has_pardiso = lambda: False
from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import compile_kernels, press
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
block = load_preset(ElastomerDesign, "design", "mini-magictac")
compile_kernels()
begin = time.process_time()
press(block, parse_object("sphere:radius_mm=4"), depth_mm=1.0)
print(time.process_time() - begin)
"""


def processor_s(library: str) -> float:
    """Processor time of one press with a library [s]."""
    done = subprocess.run([sys.executable, "-c", SOLVE, library], capture_output=True, text=True, check=True)
    return float(done.stdout)


if __name__ == "__main__":
    turns = [(processor_s("PARDISO"), processor_s("SuperLU")) for _ in range(TURNS)]
    ratio = statistics.median(slow for _, slow in turns) / statistics.median(fast for fast, _ in turns)
    print(json.dumps({"superlu_over_pardiso": round(ratio, 1), "seconds": turns}))
