"""Kinds of what is kept too long, too large or half: results, kernels, caches, states; and of wrong actions."""

import json
import os
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from laboratory.input_kinds.recordings import forces, images, refuses
from laboratory.input_kinds.registry import run, variation
from laboratory.interrupts import differences
from magicsim.config.program import changed_versions, other_code, versions
from magicsim.dataset.manifest import MANIFEST
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.writing import write_real
from magicsim.folder.listing import sealed

SMALL = (
    "rig.room='dark'", "rig.camera.exposure_grey=90", "design.footprint_mm=[8,8]", "design.lattice.spacing_mm=4",
    "design.lattice.cells_across=0", "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10",
    "render.samples=2", "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=2000",
    "references=2", "object.radius_mm=3",
)  # fmt: skip
"""A sensor that is solved and rendered within a second."""


def _begun_by(change: Callable[[dict[str, Any]], object], *words: str, at: str) -> Callable[[Path], str | None]:
    """Says what is wrong where a dataset of recordings that something else began is gone on with."""

    def attempt(work: Path) -> str | None:
        described, out = load_real(images(work, forces())), work / "set"
        write_real(described, out)
        index = json.loads((out / MANIFEST).read_text())
        change(index)
        (out / MANIFEST).write_bytes(sealed(index))
        return refuses(lambda: write_real(described, out, resume=True), *words)

    variation("results of other code", at, expected="refused in one line that names what differs")(attempt)
    return attempt


def _with_sources(index: dict[str, Any]) -> None:
    index["versions"]["sources"] = "0123456789abcdef"


_begun_by(_with_sources, "another version of sources", at="sources, with --resume")
_begun_by(lambda index: index["versions"].update(numpy="1.0"), "another version of numpy", at="a library, likewise")
_begun_by(lambda index: index["versions"].pop("sources"), "unknown code", at="a folder without a digest, likewise")


@variation("results of other code", "a baseline", expected="told which part differs")
def baseline(work: Path) -> str | None:
    """Asks what `evaluate` says of a baseline."""
    before = versions() | {"sources": "0123456789abcdef"}
    said = other_code(before, versions())
    return None if changed_versions(before, versions()) == ["sources"] and "sources" in str(said) else str(said)


KERNEL = """
import numpy as np
from magicsim.kernels import kernel
from magicsim.{other} import VALUE, own
@kernel()
def answer(x):
    return own(x) + VALUE
print(float(answer(1.0)))
"""


def _changed_kernel(change: Callable[[Path], None], *, name: str, wanted: float) -> None:
    def attempt(work: Path) -> str | None:
        import magicsim

        package = work / "magicsim"
        package.mkdir()
        shutil.copy(Path(magicsim.__file__).parent / "kernels.py", package)
        (package / "__init__.py").write_text("")
        (package / "part.py").write_text("import numba\nVALUE = 1.0\n@numba.njit\ndef own(x):\n    return x + 1.0\n")
        (package / "whole.py").write_text(KERNEL.format(other="part"))
        os.utime(package / "part.py", (1e9, 1e9))
        there = {"PYTHONPATH": str(work), "NUMBA_CACHE_DIR": str(work / "kept"), "PYTHONDONTWRITEBYTECODE": "1"}
        first = run("-m", "magicsim.whole", folder=work, environment=there)
        again = run("-m", "magicsim.whole", folder=work, environment=there)
        change(package / "part.py")
        after = run("-m", "magicsim.whole", folder=work, environment=there)
        found = [each.stdout.strip() for each in (first, again, after)]
        return None if found == ["3.0", "3.0", str(wanted)] else f"{found} {after.stderr[-300:]}"

    variation("compiled kernels of earlier sources", name, expected=f"{wanted:g} and not 3")(attempt)


def _replaced(old: str, new: str, *, keeps_time: bool = False) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        path.write_text(path.read_text().replace(old, new))
        if keeps_time:
            os.utime(path, (1e9, 1e9))

    return change


_changed_kernel(_replaced("VALUE = 1.0", "VALUE = 5.0"), name="a constant of another file", wanted=7.0)
_changed_kernel(_replaced("x + 1.0", "x + 2.0"), name="a kernel that it calls", wanted=4.0)
_changed_kernel(_replaced("x + 1.0", "x + 3.0", keeps_time=True), name="of equal size and time", wanted=5.0)


@cache
def _kept_sensor() -> Any:  # noqa: ANN401 - LiveSensor
    from magicsim.robot.live import live_sensor
    from magicsim.robot.workspace import Workspace

    space = Workspace(x_mm=(-1, 1), y_mm=(-1, 1), twist_deg=(0, 0), gap_mm=(-1, 5))
    return live_sensor("pressed", [*SMALL, "contact.friction=0.5"], workspace=space)


def _told() -> bytes:
    found = _kept_sensor().deformation
    return b"".join(each.tobytes() for each in (found.displacements_mm, found.force_n))


def _moved(**where: float) -> bytes:
    _kept_sensor().move_to(**where)
    return _told()


def _begun() -> bytes:
    _kept_sensor().reset()
    return _told()


def _pictured() -> bytes:
    image: bytes = _kept_sensor().frame().image.tobytes()
    return image


INTERRUPTED = {
    "a press": {"press": lambda: _moved(gap_mm=-0.5, x_mm=0.0, y_mm=0.0)},
    "a shear and a release": {
        "press": lambda: _moved(gap_mm=-0.5, x_mm=0.0, y_mm=0.0), "shear": lambda: _moved(x_mm=0.4),
        "release": lambda: _moved(gap_mm=0.5),
    },
    "a frame": {
        "press": lambda: _moved(gap_mm=-0.5, x_mm=0.0, y_mm=0.0),
        "frame": _pictured,
    },
}  # fmt: skip


def _interrupted(name: str) -> None:
    def attempt(work: Path) -> str | None:
        found = differences({"reset": _begun, **INTERRUPTED[name]}, most=2)
        return "; ".join(found) or None

    variation("interrupted and asked again", name, expected="the bytes of one that was not")(attempt)


for _name in INTERRUPTED:
    _interrupted(_name)


@variation("sizes and places of caches", "takes beyond their limit", expected="the oldest is gone")
def too_large(work: Path) -> str | None:
    """Keeps more than is allowed."""
    from magicsim.folder.kept import KeptFiles

    for number in range(3):
        (work / f"{number}.kept").write_bytes(b"0" * 100)
        os.utime(work / f"{number}.kept", (number, number))
    KeptFiles(folder=work, pattern=r".\.kept", most_bytes=250).shrink()
    found = sorted(each.name for each in work.iterdir())
    return None if found == ["1.kept", "2.kept"] else str(found)


@variation("sizes and places of caches", "~ in MAGICSIM_CACHE", expected="a folder of the home folder, none called ~")
def at_home(work: Path) -> str | None:
    """Asks where untouched sensors are kept."""
    there = {"HOME": str(work / "home"), "MAGICSIM_CACHE": "~/kept"}
    told = run("-m", "magicsim", "info", "doctor", "--json", folder=work, environment=there)
    found = json.loads(told.stdout)["cache"]
    wrong = found != str(work / "home" / "kept") or (work / "~").exists()
    return found if wrong else None


@variation("sizes and places of caches", "--clear-cache", expected="sensors, takes and copies go, other files stay")
def cleared(work: Path) -> str | None:
    """Removes what is kept, beside a file of somebody else."""
    names = (f"kept/magicsim-untouched-{'0' * 64}.npz", f"magicsim-takes/{'0' * 24}.npz", f"frames/{'0' * 32}.arrow")
    for name in (*names, "magicsim-takes/mine.npz"):
        (work / name).parent.mkdir(exist_ok=True)
        (work / name).write_bytes(b"0")
    there = {"MAGICSIM_CACHE": str(work / "kept"), "MAGICSIM_FRAMES": str(work / "frames")}
    run("-m", "magicsim", "info", "doctor", "--clear-cache", folder=work, environment=there)
    left = sorted(each.relative_to(work).as_posix() for each in work.rglob("*") if each.is_file())
    return None if left == ["magicsim-takes/mine.npz"] else str(left)


def _wrong_action(name: str, action: object, *words: str) -> None:
    def attempt(work: Path) -> str | None:
        from magicsim.robot.environment import GraspLift
        from magicsim.scenes.scene import load_scene

        env = GraspLift(load_scene("grip", [*SMALL]))
        env._lift = cast("Any", SimpleNamespace())  # nothing may move, so nothing is built
        return refuses(lambda: env.step(action), *words)  # type: ignore[arg-type]

    variation("actions of an environment", name, expected="refused in one line")(attempt)


_wrong_action("three numbers", np.zeros(3), "must be two finite numbers")
_wrong_action("NaN", np.array([np.nan, 0.0]), "must be two finite numbers")
_wrong_action("infinite", [0.0, np.inf], "must be two finite numbers")
_wrong_action("words", "10", "must be two finite numbers")
