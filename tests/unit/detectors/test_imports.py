import json
import subprocess
import sys

from .conftest import grid_frame, light_frame, near_frame

ALLOWED = {"numpy", "cv2", "magicsim"}
LEAF = {
    "magicsim", "magicsim.errors", "magicsim.config", "magicsim.config.documents",
    "magicsim.config.presets", "magicsim.conventions", "magicsim.frame_class",
    "magicsim.config.extensions", "magicsim.names", "magicsim.waiting",
}  # fmt: skip

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


ALONE = """
import sys

class Refuser:
    def find_spec(self, name, path=None, target=None):
        root = name.split(".")[0]
        if root not in {"numpy", "cv2", "magicsim"} | set(sys.stdlib_module_names):
            raise ImportError(f"{name} is not installed")

sys.meta_path.insert(0, Refuser())
from magicsim.detectors.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


def test_images_and_videos_are_judged_where_nothing_else_can_be_imported(tmp_path, save, write_video):
    for index in range(4):
        save(tmp_path / "rest" / f"{index}.png", grid_frame())
    write_video(tmp_path / "clip.avi", [near_frame(), light_frame()])
    for source, count in (("rest", 4), ("clip.avi", 2)):
        arguments = [str(tmp_path / source), "--reference", str(tmp_path / "rest"), "--grasp", "--json"]
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", ALONE, *arguments], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        assert len(json.loads(done.stdout)["frames"]) == count
