import subprocess
import sys

ALLOWED = {"numpy", "cv2", "magicsim"}
LEAF = {"magicsim", "magicsim.errors", "magicsim.presets", "magicsim.conventions"}

PROBE = """
import sys
before = set(sys.modules)
import magicsim.detectors
print(*sorted(set(sys.modules) - before))
"""


def loaded_modules() -> list[str]:
    done = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_detectors_load_only_numpy_opencv_and_the_standard_library():
    roots = {name.split(".")[0] for name in loaded_modules()}
    assert {"numpy", "cv2"} <= roots
    assert not {root for root in roots if root not in sys.stdlib_module_names} - ALLOWED


def test_detectors_load_no_other_part_of_the_package_than_the_leaf():
    own = {name for name in loaded_modules() if name.split(".")[0] == "magicsim"}
    assert {name for name in own if not name.startswith("magicsim.detectors")} <= LEAF
