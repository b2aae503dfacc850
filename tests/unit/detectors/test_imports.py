import json
import subprocess
import sys

from .conftest import grid_frame, light_frame, near_frame

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
