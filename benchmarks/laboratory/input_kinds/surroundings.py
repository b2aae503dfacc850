"""Kinds of surroundings: streams, widths, locales, folders, names of files, and what else runs in the process."""

import os
import subprocess
from collections.abc import Mapping
from pathlib import Path

import trimesh

from laboratory.input_kinds.registry import Attempt, one_line_with, run, variation
from magicsim.cli.surroundings import WIDEST

ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
"""A locale of ASCII alone, where Python may not leave it."""


def _put(*settings: str) -> list[str]:
    return [part for each in settings for part in ("--set", each)]


PRESS = ["press", "uniform-block", "--depth-mm", "0.3", *_put("lattice.spacing_mm=2", "lattice.cells_across=0")]
BALL = [*PRESS, "--object", "sphere:radius_mm=4"]
EXPORT = ["export", "uniform-block", "--out", "part.stl", *_put("footprint_mm=[10,10]")]
SMALL = _put(
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=24", "rig.camera.rows=32",
    "rig.camera.field_mm=10", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
    "render.anchor_particles=2000", "references=6",
)  # fmt: skip
"""Of a scene that is rendered in a second."""
NOBODY = "import pwd\ndef none(_): raise KeyError\npwd.getpwuid = pwd.getpwnam = none\n"
"""Takes this user's entry among the passwords away."""
MAIN = "from magicsim.cli import main\nimport sys\nsys.argv[1:] = {words!r}\nmain()"
FORCE = "force_n: 0, 0, "


def _command(folder: Path, *words: str, streams: str = "", **variables: str | None) -> subprocess.CompletedProcess[str]:
    """Runs a command with what a shell does to its streams, such as `>&-`."""
    code = "import os, sys; os.execv('/bin/sh', ['sh', '-c', sys.argv[1], sys.executable, *sys.argv[2:]])"
    return run("-c", code, f'"$0" -m magicsim "$@" {streams}', *words, folder=folder, environment=variables)


def _ends(ended: subprocess.CompletedProcess[str], *words: str, code: int = 0) -> str | None:
    """What is wrong with the end of a command that has an exit code and whose result holds some words."""
    if ended.returncode != code or "Traceback" in ended.stderr or "Exception ignored" in ended.stderr:
        return f"exit code {ended.returncode}: {ended.stderr[-300:]}"
    missing = [word for word in words if word not in ended.stdout]
    return f"without {missing}: {ended.stdout[-300:]}" if missing else None


def _kind(name: str, expected: str, **attempts: Attempt) -> None:
    for each, attempt in attempts.items():
        variation(name, each.replace("_", " "), expected=expected)(attempt)


def _width(columns: str) -> Attempt:
    def attempt(work: Path) -> str | None:
        ended = run("-m", "magicsim", "simulate", "--help", folder=work, environment={"COLUMNS": columns}, timeout_s=60)
        widest = max(map(len, ended.stdout.splitlines()), default=0)
        return _ends(ended, "Simulate a scene") or (f"{widest} columns" if widest > WIDEST else None)

    return attempt


_kind(
    "width of the terminal", "help in a moment, its lines of a bounded width",
    COLUMNS_0=_width("0"), COLUMNS_1=_width("1"), COLUMNS_999999999=_width("999999999"),
)  # fmt: skip


def _whole(work: Path, ended: subprocess.CompletedProcess[str], code: int = 0) -> str | None:
    volume = trimesh.load_mesh(work / "part.stl").volume if (work / "part.stl").is_file() else 0.0
    return _ends(ended, code=code) or (f"a part of {volume:g} mm3" if volume < 100 else None)


_kind(
    "closed streams", "the result on disk is whole; an error has its exit code",
    standard_output=lambda work: _whole(work, _command(work, *EXPORT, streams=">&-")),
    all_three=lambda work: _whole(work, _command(work, *EXPORT, streams="<&- >&- 2>&-")),
    standard_error_of_a_refusal=lambda work: _ends(_command(work, "simulate", "plan", "nera", streams="2>&-"), code=2),
)  # fmt: skip
_kind(
    "a reader that has gone", "exit code of the work, or 141; the result on disk is whole",
    output_in_head=lambda work: _ends(_command(work, "info", "schema", streams="| head -1"), "{"),
    progress=lambda work: _whole(work, _command(work, *EXPORT, streams="2>&1 >/dev/null | true")),
    full_disk=lambda work: one_line_with(_command(work, "--help", streams=">/dev/full"), "No space left"),
)  # fmt: skip


def _named(work: Path, *words: str, file: str) -> str | None:
    ended = run("-m", "magicsim", *words, folder=work, environment=ASCII)
    return _ends(ended) or (None if (work / file).exists() else f"{os.listdir(work)}")


def _scene_with_umlaut(work: Path) -> str | None:
    trimesh.creation.icosphere(subdivisions=2, radius=20.0).export(work / "Ölbad.stl")
    scene = 'schema_version = 1\ndesign = "mini-magictac"\nrig = "digit-office"\nseed = 1\n[object]\nkind = "mesh"\n'
    (work / "Höhe.toml").write_text(f'{scene}path = "Ölbad.stl"\n[[keyframes]]\nframe = 0\n', encoding="utf-8")
    return _named(work, "simulate", "Höhe.toml", *SMALL, "--out", "größe", file="größe/config.toml") or (
        None if "Ölbad.stl" in (work / "größe" / "config.toml").read_text(encoding="utf-8") else "another name"
    )


_kind(
    "a locale of ASCII", "it works, files are in UTF-8",
    scene_mesh_and_folder_with_umlauts=_scene_with_umlaut,
    drawn_curve_with_an_umlaut=lambda work: _named(work, *BALL, "--curve", "größe.png", "--points", "3",
                                                   file="größe.png"),
    error_about_an_umlaut=lambda work: one_line_with(
        run("-m", "magicsim", "simulate", "plan", "nöra", folder=work,
            environment=ASCII | {"PYTHONIOENCODING": "utf-8"}), "unknown scene 'nöra'"),
    output_in_ASCII=lambda work: one_line_with(
        run("-m", "magicsim", "simulate", "plan", "nöra", folder=work, environment={"PYTHONIOENCODING": "ascii"}),
        r"unknown scene 'n\xf6ra'"),
)  # fmt: skip


def _pressed(name: str, *words: str) -> Attempt:
    def attempt(work: Path) -> str | None:
        trimesh.creation.icosphere(subdivisions=3, radius=4.0).export(work / "ball.stl")
        (work / "ball.stl").rename(work / name)
        ended = run("-m", "magicsim", *PRESS, "--object", f"mesh:path={name},scale=1", *words, folder=work)
        return _ends(ended, *([] if words else [FORCE]))

    return attempt


_kind(
    "signs in names of files", "it works, or one line names the file",
    commas_of_a_mesh=_pressed("a,b c,d=2.stl"),
    other_signs=_pressed("a=#%'ü:\\.stl"),
    formula_in_a_title=_pressed("$a{$.stl", "--curve", "$b^$.png", "--points", "3"),
    bytes_that_are_no_text=lambda work: one_line_with(
        run("-m", "magicsim", "simulate", "near", "--out", os.fsdecode(b"r\xff"), folder=work), "no name in utf-8"),
)  # fmt: skip


def _homeless(work: Path, *words: str) -> subprocess.CompletedProcess[str]:
    gone: Mapping[str, str | None] = {"HOME": None, "XDG_CACHE_HOME": None}
    return run("-c", NOBODY + MAIN.format(words=list(words)), folder=work, environment=gone)


_kind(
    "no home folder", "it works without a cache, or one line says what is missing",
    doctor=lambda work: _ends(_homeless(work, "info", "doctor"), "cache: -"),
    scene=lambda work: _ends(_homeless(work, "simulate", "near", *SMALL, "--out", "run"), "frames: 7"),
    completion=lambda work: one_line_with(_homeless(work, "info", "completion", "bash", "--install"), "no home folder"),
)  # fmt: skip


def _uncached(name: str) -> Attempt:
    def attempt(work: Path) -> str | None:
        (work / "file").touch()
        words = ("simulate", "near", *SMALL, "--out", "run")
        ended = run("-m", "magicsim", *words, folder=work, environment={"MAGICSIM_CACHE": name})
        told = ended.stderr.count("nothing is kept in")
        return _ends(ended, "frames: 7") or (None if told == 1 else f"{told} lines: {ended.stderr[-300:]}")

    return attempt


_kind(
    "a cache that cannot be written", "frames, and one line",
    a_file=_uncached("file"), below_a_file=_uncached("file/below"), a_device=_uncached("/dev/null/below"),
)  # fmt: skip


def _deleted(*words: str) -> Attempt:
    def attempt(work: Path) -> str | None:
        there = work / "gone"
        there.mkdir()
        code = f"import os; os.rmdir({str(there)!r})\n" + MAIN.format(words=list(words))
        return one_line_with(run("-c", code, folder=there), "the current folder is gone")

    return attempt


_kind(
    "a working folder that is gone", "one line",
    plan=_deleted("simulate", "plan", "near"), press=_deleted(*BALL), export=_deleted(*EXPORT),
)  # fmt: skip


def _set(variant: str, *, back: bool = False) -> Attempt:
    def attempt(work: Path) -> str | None:
        lines = [
            "import magicsim; from magicsim.errors import MagicsimError; from magicsim.light.backend import VARIANT",
            "import mitsuba",
            f"scene = magicsim.load_scene('near', {SMALL[1::2]!r})",
            "images = magicsim.simulate(scene).images",
            f"mitsuba.set_variant({variant!r})",
            "mitsuba.set_variant(VARIANT)" if back else "",
            "try: print((magicsim.simulate(scene).images == images).all())",
            "except MagicsimError as error: print(error)",
        ]
        ended = run("-c", "\n".join(lines), folder=work)
        return _ends(ended, "True" if back else "was called: set_variant(")

    return attempt


_kind(
    "the renderer's variant set by somebody else", "the same frames, or one line",
    scalar_rgb=_set("scalar_rgb"), scalar_spectral=_set("scalar_spectral"),
    scalar_rgb_and_back=_set("scalar_rgb", back=True),
)  # fmt: skip


def _with(*words: str, **variables: str | None) -> Attempt:
    return lambda work: _ends(run(*words, *BALL, folder=work, environment=variables), FORCE)


_kind(
    "Python's own switches", "it works",
    without_docstrings=_with("-OO", "-m", "magicsim"),
    safe_path=_with("-P", "-m", "magicsim"),
    one_that_says_so=lambda work: _ends(run("-OO", "-m", "magicsim", "--help", folder=work), "Without descriptions"),
)  # fmt: skip
_kind(
    "variables of libraries", "it works, or one line",
    OMP_NUM_THREADS=_with("-m", "magicsim", OMP_NUM_THREADS="many"),
    TMPDIR=_with("-m", "magicsim", TMPDIR="/nowhere"),
    NUMBA_NUM_THREADS=lambda work: one_line_with(
        run("-m", "magicsim", *BALL, folder=work, environment={"NUMBA_NUM_THREADS": "0"}), "NUMBA_NUM_THREADS = '0'"),
    NUMBA_CACHE_DIR=_with("-m", "magicsim", NUMBA_CACHE_DIR="/dev/null"),
)  # fmt: skip
