"""Does any broken file of a user end in a traceback, an unreadable message, a long wait or a full memory?

    python benchmarks/fuzz_inputs.py --toml 20000 --files 1000 --seed 0 --out docs/benchmarks/fuzz-inputs.json

Mutates the shipped TOML files (keys dropped, doubled, swapped; extreme numbers, wrong types, deep nesting, long names,
odd characters, broken text) and gives each to the loader of its kind and to what is computed from it at once; mutates
meshes, images, tables and baselines (bits flipped, bytes cut, doubled, inserted, header numbers changed) and gives each
to its reader. Counts what was loaded, what was refused in one readable line, and what was not. Exit code 1 where there
is a traceback or an unreadable line.
"""

import argparse
import json
import logging
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from random import Random
from types import FrameType
from typing import Any
from unicodedata import category

import cv2
import numpy as np
import tomli_w
import trimesh

from magicsim.config.documents import read_toml
from magicsim.config.models import load_preset
from magicsim.config.presets import find_preset, preset_names
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.detectors.picture import read_image
from magicsim.detectors.profile import load_profile
from magicsim.detectors.video import quiet_opencv
from magicsim.errors import MagicsimError
from magicsim.evaluation.baseline import load_baseline
from magicsim.evaluation.suite import load_suite
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.files.mesh_file import load_mesh
from magicsim.geometry.grid import resolve_grid
from magicsim.geometry.objects.kinds import find_object
from magicsim.judge.recorded import read_classes, read_recording
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import load_scene
from magicsim.simulation.plan import plan_scene
from magicsim.sweep.designs import count_designs, design_with
from magicsim.sweep.sweep_file import load_sweep

SLOW_S, STUCK_S = 2.0, 30.0
LONGEST = 500
"""Longest line [characters]."""
NUMBERS = (0, -1, 1e-300, 1e300, 10**400, -(10**400), float("nan"), float("inf"), 2**31, 2**63, 1e9, 10**9, 0.5, -0.0)
NAMES = (
    "", "x" * 100_000, "\x1b[31mred\x1b[0m", "\u202eevil", "a\u0000b", "<script>alert(1)</script>", "../../etc", "=1+1",
    "\n\nline", "\u200b", "{{ 7*7 }}", "~nobody/x.toml", "/" * 5000, "😀" * 50, "mini-magictac", "nan", "\ufeff",
)  # fmt: skip
Read = Callable[[Path], object]


@dataclass(slots=True, kw_only=True)
class Found:
    """What became of the files of one kind."""

    files: int = 0
    loaded: int = 0
    refused: int = 0
    """One readable line."""
    unreadable: list[str] = field(default_factory=list)
    """Lines that are too long, or hold what cannot be seen."""
    tracebacks: dict[str, int] = field(default_factory=dict)
    """Errors that are no deliberate ones, by kind and place."""
    slow: list[str] = field(default_factory=list)
    """What took more than 2 s, with its time [s]."""
    longest_s: float = 0.0
    stderr_bytes: int = 0
    """What libraries printed."""

    @property
    def is_sound(self) -> bool:
        """Whether every file was loaded or refused as it should be."""
        return not self.unreadable and not self.tracebacks


class StuckError(Exception):
    """A file took longer than 30 s."""


def try_file(read: Read, path: Path, what: str, found: Found) -> None:
    """Gives a file to its reader and counts what becomes of it."""
    found.files += 1
    begin = time.perf_counter()
    signal.setitimer(signal.ITIMER_REAL, STUCK_S)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read(path)
        found.loaded += 1
    except MagicsimError as error:
        if is_readable(str(error)):
            found.refused += 1
        else:
            found.unreadable.append(str(error)[:200])
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        place = traceback.extract_tb(error.__traceback__)[-1]
        own = [each for each in traceback.extract_tb(error.__traceback__) if "magicsim" in each.filename] or [place]
        name = f"{type(error).__name__} in {Path(own[-1].filename).name}:{own[-1].lineno}: {str(error)[:120]!r}"
        found.tracebacks[name] = found.tracebacks.get(name, 0) + 1
        keep = os.environ.get("FUZZ_KEEP")
        if keep:
            Path(keep, f"{found.files}-{path.name}").write_bytes(path.read_bytes())
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    taken = time.perf_counter() - begin
    found.longest_s = max(found.longest_s, round(taken, 2))
    if taken > SLOW_S:
        found.slow.append(f"{what}: {taken:.1f}")


def is_readable(line: str) -> bool:
    """Whether a message is one line of at most 500 characters without any that hide."""
    return 0 < len(line) <= LONGEST and all(each.isprintable() or category(each) == "Zs" for each in line)


def load_whole_scene(path: Path) -> object:
    """A scene, its object and its plan."""
    scene = load_scene(path)
    return scene.object.shape() if scene.object is not None else None, plan_scene(scene)


def load_whole_recipe(path: Path) -> object:
    """A recipe, and its first and last episode."""
    episodes = draw_episodes(load_recipe(path))
    return episodes[0], episodes[-1]


def load_whole_sweep(path: Path) -> object:
    """A sweep, how many designs it has, and its base."""
    sweep = load_sweep(path)
    return count_designs(sweep), design_with(sweep, 0, {})


def load_whole_design(path: Path) -> object:
    """A design, and its grid."""
    return resolve_grid(load_preset(ElastomerDesign, "design", path))


def load_whole_object(path: Path) -> object:
    """An object, its shape and what the camera sees of it."""
    thing = find_object(path)
    return thing.shape(), thing.surface()


LOADERS: dict[str, Read] = {
    "design": load_whole_design,
    "object": load_whole_object,
    "scene": load_whole_scene,
    "rig": partial(load_preset, Rig, "rig"),
    "recipe": load_whole_recipe,
    "profile": load_profile,
    "suite": load_suite,
    "sweep": load_whole_sweep,
}


def mutated_tables(data: dict[str, Any], random: Random) -> dict[str, Any]:
    """A copy of nested tables with one to three things changed."""
    result: dict[str, Any] = json.loads(json.dumps(data))
    for _ in range(random.randint(1, 3)):
        holder, key = random.choice(list(places(result)))
        value = holder[key]
        match random.randrange(9):
            case 0:
                del holder[key]
            case 1 if isinstance(holder, dict):
                holder[random.choice([*NAMES, key + "s", str(key).upper()])] = value
            case 2:
                other, name = random.choice(list(places(result)))
                holder[key], other[name] = json.loads(json.dumps(other[name])), json.loads(json.dumps(value))
            case 3 | 4:
                holder[key] = random.choice(NUMBERS)
            case 5:
                holder[key] = random.choice(NAMES)
            case 6:
                holder[key] = random.choice([True, [], {}, [[]], "1", [1, 2, 3], {"kind": "x"}, {"low": 1, "high": 0}])
            case 7 if isinstance(value, list) and value:
                holder[key] = value * random.choice([2, 3, 300])
            case _:
                if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 10**9:
                    holder[key] = value * random.choice([-1, 0, 1e-6, 1e6, 2, 0.5])
        if not result:
            return result
    return result


def places(value: dict[str, Any] | list[Any]) -> Iterator[tuple[Any, Any]]:
    """Every table or list of a nesting with each of its keys."""
    for key, inner in list(value.items()) if isinstance(value, dict) else list(enumerate(value)):
        yield value, key
        if isinstance(inner, dict | list):
            yield from places(inner)


def broken_text(text: str, random: Random) -> str:
    """A text with something put in, left out or doubled."""
    lines = text.splitlines()
    at = random.randrange(len(lines))
    deep = random.choice([40, 5000])
    match random.randrange(8):
        case 0:
            lines[at] = lines[at][: random.randint(0, len(lines[at]))]
        case 1:
            lines.insert(at, lines[random.randrange(len(lines))])
        case 2:
            del lines[at]
        case 3:
            lines.insert(at, "x = " + "[" * deep + "]" * deep)
        case 4:
            lines.insert(at, ".".join(["a"] * deep) + " = 1")
        case 5:
            lines.insert(0, "design = " + "{a=" * deep + "1" + "}" * deep)
        case 6:
            lines.insert(at, f'"{random.choice(NAMES[1:])}" = 1')
        case _:
            place = random.randrange(len(text))
            return (
                text[:place] + random.choice(["\x00", "\u202e", "=", "[", '"', "'''", "9" * 5000]) + text[place + 1 :]
            )
    return "\n".join(lines)


def fuzz_toml(count: int, seed: int, folder: Path) -> Found:
    """Mutated TOML files through the loaders of their kinds."""
    random, found = Random(seed), Found()
    sources = [(kind, find_preset(kind, name)) for kind in LOADERS for name in preset_names(kind)]
    parsed = {path: read_toml(path) for _, path in sources}
    for number in range(count):
        kind, source = random.choice(sources)
        path = folder / f"{kind}.toml"
        if random.random() < 0.7:
            text = tomli_w.dumps(mutated_tables(parsed[source], random))
        else:
            text = broken_text(source.read_text(encoding="utf-8"), random)
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        try_file(LOADERS[kind], path, f"{kind} {source.stem} {number}", found)
    return found


def changed_bytes(content: bytes, random: Random) -> bytes:  # noqa: PLR0911 - one each
    """A file with something flipped, cut, doubled, put in or put together anew."""
    at, length = random.randrange(len(content)), random.choice([1, 4, 100, 5000])
    match random.randrange(7):
        case 0:
            return content[:at]
        case 1:
            return content[:at] + bytes([content[at] ^ 1 << random.randrange(8)]) + content[at + 1 :]
        case 2:
            place = random.randrange(min(200, len(content)))  # numbers of the header
            return content[:place] + random.choice([b"\xff" * 4, b"\0" * 4, b"\x7f\xff"]) + content[place + 4 :]
        case 3:
            return content[:at] + random.randbytes(length) + content[at:]
        case 4:
            return content[:at] + content[at + length :]
        case 5:
            return content[:at] + content[at : at + length] * 3 + content[at + length :]
        case _:
            return content.replace(
                random.choice([b"0", b"1", b" ", b"\n", b"e"]), random.choice([b"9", b"nan", b"-", b""])
            )


def sample_files(folder: Path) -> list[tuple[str, bytes, Read]]:
    """Whole files of every kind that is read, by name."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=3.0)
    ball.visual.vertex_colors = np.full((len(ball.vertices), 4), 128, np.uint8)
    meshes = {
        "a.stl": ball.export(file_type="stl"),
        "b.stl": ball.export(file_type="stl_ascii").encode(),
        "c.ply": ball.export(file_type="ply"),
        "d.ply": ball.export(file_type="ply", encoding="ascii"),
        "e.obj": ball.export(file_type="obj").encode(),
        "f.glb": ball.export(file_type="glb"),
    }
    image = np.random.default_rng(0).integers(0, 255, (48, 64, 3), np.uint8)
    images = {
        f"g{suffix}": cv2.imencode(suffix, image)[1].tobytes()
        for suffix in (".png", ".jpg", ".bmp", ".ppm", ".tif", ".webp")
    }
    (folder / "00000.png").write_bytes(images["g.png"])
    truth = "file,is_reference,gap_mm,force_n,flashlight\n" + "00000.png,1,,0,0\n" * 3 + "00000.png,0,-0.4,0.8,0\n" * 3
    labels = "file,class\n" + "00000.png,Reference\n" * 3 + "00000.png,Contact\n" * 3
    baseline = (find_preset("suite", "small").parents[1] / "baselines").glob("*.json")
    files: list[tuple[str, bytes, Read]] = [(name, content, read_solid) for name, content in meshes.items()]
    files += [(name, content, read_image) for name, content in images.items()]
    files += [("truth.csv", truth.encode(), lambda path: read_recording(path.parent))]
    files += [("labels.csv", labels.encode(), lambda path: read_classes(path).episode())]
    return files + [(path.name, path.read_bytes(), load_baseline) for path in sorted(baseline)]


def read_solid(path: Path) -> object:
    """A mesh, scaled at random so that it is not kept from the file before."""
    from magicsim.geometry.files import mesh_file

    mesh_file._load.cache_clear()
    return load_mesh(str(path))


def fuzz_files(count: int, seed: int, folder: Path) -> Found:
    """Mutated meshes, images, tables and baselines through their readers."""
    random, found = Random(seed), Found()
    samples = sample_files(folder)
    for number in range(count):
        name, content, read = samples[number % len(samples)]
        for _ in range(random.randint(1, 2)):
            content = changed_bytes(content, random) or b"\0"
        path = folder / name
        path.write_bytes(content)
        with quiet_opencv():
            try_file(read, path, f"{name} {number}", found)
    return found


@contextmanager
def counted_stderr(found: list[int]) -> Iterator[None]:
    """Counts what is printed to standard error inside the block, by whatever library."""
    sys.stderr.flush()
    kept = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            sys.stderr.flush()
            os.dup2(kept, 2)
            os.close(kept)
            found.append(file.seek(0, os.SEEK_END))


def fuzz(toml: int, files: int, seed: int) -> dict[str, Any]:
    """Both, and the peak of memory, as the JSON that is written."""
    signal.signal(signal.SIGALRM, _stuck)
    logging.getLogger("magicsim").setLevel(logging.ERROR)
    results: dict[str, Found] = {}
    for name, run, count in (("toml", fuzz_toml, toml), ("files", fuzz_files, files)):
        printed: list[int] = []
        with tempfile.TemporaryDirectory() as folder, counted_stderr(printed):
            results[name] = run(count, seed, Path(folder))
        results[name].stderr_bytes = printed[0]
    return {
        "seed": seed,
        **{name: asdict(each) for name, each in results.items()},
        "peak_memory_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3),
        "is_sound": all(each.is_sound for each in results.values()),
    }


def _stuck(signal_number: int, frame: FrameType | None) -> None:
    del signal_number, frame
    raise StuckError


def main() -> None:
    """Mutates, reads, and writes what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--toml", type=int, default=20_000, help="TOML files")
    parser.add_argument("--files", type=int, default=1_000, help="meshes, images, tables and baselines")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="JSON file; standard output by default")
    options = parser.parse_args()
    text = json.dumps(fuzz(options.toml, options.files, options.seed), indent=1) + "\n"
    if options.out is not None:
        options.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)
    sys.exit(0 if json.loads(text)["is_sound"] else 1)


if __name__ == "__main__":
    main()
