"""Commands with extreme and forbidden settings: each ends in time, with a result or one line, and leaves no debris.

python benchmarks/fuzz_commands.py --count 400 --seed 1 [--workers 2]

Every case sets one to three random fields to a limit, to a value between its limits or to one beyond them. Commands run
one after the other in warm processes of their own, so that one that is aborted is noticed and costs no other. Prints
JSON: counts, and the failing cases as command lines; exit code 1 where there are any.
"""

import argparse
import json
import os
import random
import re
import shlex
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

SCENE, RECIPE = "scene.toml", "recipe.toml"
SILENCE_S, LIMIT_S = 20.0, 300.0
"""Longest time without a word, and in all, that is no failure."""
CASES_PER_PROCESS = 60
POLL_S = 0.2
TINY = """
design = "mini-magictac"
rig = "digit-rgb"
references = 1
[render]
samples = 2
particles = 400
anchor_samples = 2
anchor_particles = 800
"""
FILES = {
    SCENE: f"schema_version = 1{TINY}[object]\nkind = 'sphere'\nradius_mm = 4.0\n"
    "[[keyframes]]\nframe = 0\ngap_mm = 2.0\n[[keyframes]]\nframe = 1\ngap_mm = -0.3\n"
    "[[keyframes]]\nframe = 2\nflashlight = true\n",
    RECIPE: f"schema_version = 1\nepisodes = 1{TINY}[[objects]]\nkind = 'sphere'\nradius_mm = 3.0\n"
    "[[paths]]\nkind = 'hover'\nnearest_mm = 1.0\napproach_frames = 1\nretreat_frames = 0\n",
}
SMALL_CAMERA = ["--set", "rig.camera.columns=24", "--set", "rig.camera.rows=32"]
COSTLY = ("render.samples", "render.particles", "render.anchor_", "rig.camera.columns", "rig.camera.rows", "episodes",
          "keyframes", "references", "timeout_s", "render.estimator", "frames")  # fmt: skip
"""Fields whose upper limits are hours of honest work."""
FORBIDDEN = ("nan", "inf", "-inf", "1e300", "-1e300", "1e-300", "-1", "0", "true", "'x'", "[]", "{}", str(10**30))
WEIGHTS = {"plan": 5, "simulate": 10, "render": 8, "press": 5, "calibration": 2, "durometer": 1, "dataset": 2}
ALLOWED_CODES = {"dataset": {0, 1, 2}}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One command."""

    command: str
    code: int
    seconds: float
    silent_s: float
    """Longest time without a word on stderr [s]."""
    problems: list[str]
    said: str
    """The end of what it wrote on stderr."""


def fields(schema: dict[str, Any], part: dict[str, Any], path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Dotted names of all fields that hold no table, with their schemas."""
    part = resolved(schema, part)
    for name, inner in part.get("properties", {}).items():
        below, chosen = f"{path}.{name}" if path else name, resolved(schema, inner)
        if "properties" in chosen:
            yield from fields(schema, chosen, below)
        elif not below.startswith(COSTLY) and name != "schema_version":
            yield below, chosen


def resolved(schema: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """A schema without references; of alternatives the table, or the first that is not null."""
    while "$ref" in part or "anyOf" in part:
        if "$ref" in part:
            part = schema["$defs"][part["$ref"].rpartition("/")[2]]
        else:
            options = [each for each in part["anyOf"] if each.get("type") not in {"null", "string"}] or part["anyOf"]
            part = options[0]
    return part


def written(schema: dict[str, Any], part: dict[str, Any], draw: random.Random) -> str:
    """A value in TOML: mostly one that the schema allows, often a limit."""
    part = resolved(schema, part)
    if draw.random() < 0.03:
        return draw.choice(FORBIDDEN)
    if "oneOf" in part:
        return written(schema, draw.choice(part["oneOf"]), draw)
    if part.get("type") == "array":
        inner = part.get("prefixItems") or [part["items"]] * draw.randint(0, 3)
        values = [written(schema, each, draw) for each in inner]
        if all("minimum" in resolved(schema, each) for each in inner) and draw.random() < 0.3:
            values = [repr(resolved(schema, each)["minimum"]) for each in inner]
        ordered = [re.sub(r"\bframe = [^,}]*", f"frame = {place}", value) for place, value in enumerate(values)]
        return f"[{', '.join(ordered)}]"
    if "properties" in part:
        needed = part.get("required", [])
        keys = [key for key in part["properties"] if key in needed or draw.random() < 0.3]
        pairs = [f"{key} = {written(schema, part['properties'][key], draw)}" for key in keys]
        return f"{{{', '.join(pairs)}}}"
    if part.get("type") in {"number", "integer"}:
        return number(part, draw)
    return json.dumps(draw.choice(part.get("enum") or [part.get("const", True)]))


def number(part: dict[str, Any], draw: random.Random) -> str:
    """A limit, a place between the limits, or a little beyond one of them."""
    low = part.get("minimum", part.get("exclusiveMinimum", -1e6))
    high = part.get("maximum", part.get("exclusiveMaximum", 1e6))
    value = draw.choice([low, high, draw.uniform(low, high), max(low, min(high, 1.0))])
    if draw.random() < 0.05:
        value = draw.choice([2 * low - 1, 2 * high + 1])
    return repr(int(value)) if part.get("type") == "integer" else repr(float(value))


def case(draw: random.Random, schemas: dict[str, dict[str, Any]], folder: Path) -> list[str]:
    """The arguments of one command; its results go to a folder."""
    command = draw.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]
    kind = {"press": "design", "durometer": "design", "dataset": "recipe"}.get(command, "scene")
    schema = schemas[kind]
    known = list(fields(schema, schema, ""))
    if kind == "scene":
        known += [("keyframes", schema["properties"]["keyframes"]), ("object", schema["properties"]["object"])] * 3
    settings = []
    for name, part in draw.sample(known, draw.randint(1, 3)):
        settings += ["--set", f"{name}={written(schema, part, draw)}"]
    small = SMALL_CAMERA if kind != "design" else []
    more = {
        "simulate": ["--out", str(folder / "out")],
        "dataset": ["--out", str(folder / "out"), "--workers", "1"],
        "render": ["--frame", str(draw.choice([0, 0, 1, 1, 2, 2, 9]))],
        "press": [
            "--object", draw.choice(["sphere:radius_mm=4", pressed_object(schemas["object"], draw)]),
            "--depth-mm", draw.choice(["0.1", "0.3", "0.5", "1", "1", "1e-9", "1e9", "nan"]),
            "--shear-mm", draw.choice(["0,0", "0,0", "0.2,0", "0.2,0", "1e9,0", "nan,0"]),
            "--friction", draw.choice(["0", "0", "0.5", "0.5", "5", "1e300"]),
        ],
    }  # fmt: skip
    source = {"design": "mini-magictac", "recipe": str(folder.parent / RECIPE)}.get(kind, str(folder.parent / SCENE))
    return [command, source, *small, *settings, *more.get(command, [])]


def pressed_object(schema: dict[str, Any], draw: random.Random) -> str:
    """An object as `press` takes it."""
    part = resolved(schema, draw.choice(schema["oneOf"]))
    needed = [key for key in part["required"] if key != "kind"]
    values = [f"{key}={written(schema, part['properties'][key], draw)}" for key in needed]
    return f"{part['properties']['kind']['const']}:{','.join(values)}".replace(" ", "")


class Runner:
    """A warm process that runs commands, and is replaced when it has ended."""

    def __init__(self) -> None:
        """Starts nothing yet."""
        self._process: subprocess.Popen[str] | None = None
        self._done = 0

    def run(self, arguments: list[str], folder: Path) -> Outcome:
        """Runs one command, and looks at what it said and left."""
        folder.mkdir()
        told, start = folder.parent / f"{folder.name}.stderr", time.monotonic()
        told.touch()
        process = self._warm()
        process.stdin.write(json.dumps({"arguments": arguments, "told": str(told)}) + "\n")
        process.stdin.flush()
        code, silent = self._wait(process, told, folder / ".code", start)
        said = told.read_text(encoding="utf-8", errors="replace")
        problems = [f"exit code {code}"] if code not in ALLOWED_CODES.get(arguments[0], {0, 2}) else []
        problems += ["traceback"] if "Traceback" in said else []
        problems += [f"{silent:.0f} s without a word"] if silent > SILENCE_S else []
        left = {path.name for path in folder.iterdir()} - {".code"} - ({"out"} if code == 0 else set())
        if arguments[0] != "dataset":
            problems += [f"left {name}" for name in sorted(left) if not name.endswith(".lock")]
        return Outcome(
            command=shlex.join(["magicsim", *arguments]), code=code, seconds=round(time.monotonic() - start, 1),
            silent_s=round(silent, 1), problems=problems, said=said[-1000:] if problems else "",
        )  # fmt: skip

    def close(self) -> None:
        """Ends the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        self._process, self._done = None, 0

    def _warm(self) -> "subprocess.Popen[str]":
        if self._done >= CASES_PER_PROCESS:
            self.close()
        if self._process is None:
            command = [sys.executable, __file__, "--serve"]
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, text=True, stdout=subprocess.DEVNULL)
        self._done += 1
        return self._process

    def _wait(self, process: "subprocess.Popen[str]", told: Path, code: Path, start: float) -> tuple[int, float]:
        size, heard, silent = 0, start, 0.0
        while not code.exists():
            time.sleep(POLL_S)
            now = time.monotonic()
            silent = max(silent, now - heard)
            if told.stat().st_size != size:
                size, heard = told.stat().st_size, now
            if process.poll() is not None:
                self._process = None
                return process.returncode, silent
            if now - start > LIMIT_S:
                self.close()
                return -9, silent
        return int(code.read_text()), silent


def serve() -> None:
    """Runs the commands that come as lines, each as a process of its own would."""
    from magicsim.cli.entry import main as command

    for line in sys.stdin:
        task = json.loads(line)
        told = Path(task["told"])
        with told.open("ab") as file:
            os.dup2(file.fileno(), 2)
        sys.argv, code = ["magicsim", *task["arguments"]], 0
        try:
            command()
        except SystemExit as error:
            code = error.code if isinstance(error.code, int) else int(error.code is not None)
        except BaseException:
            traceback.print_exc()
            code = 1
        sys.stderr.flush()
        partial = told.with_suffix(".code")
        partial.write_text(str(code))
        partial.replace(told.with_suffix("") / ".code")


def main() -> None:
    """Runs the cases and prints what came of them."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve()
        return
    from magicsim.cli.schema import schema_of

    schemas = {kind: schema_of(kind) for kind in ("scene", "design", "recipe", "object")}
    draw = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as place:
        root = Path(place)
        for name, text in FILES.items():
            (root / name).write_text(text)
        tasks = [(case(draw, schemas, root / f"{number}"), root / f"{number}") for number in range(options.count)]
        with ThreadPoolExecutor(options.workers) as pool:
            parts = [tasks[number :: options.workers] for number in range(options.workers)]
            outcomes = [outcome for part in pool.map(_run_all, parts) for outcome in part]
    failed = [asdict(each) for each in outcomes if each.problems]
    counts = Counter(f"{each.command.split()[1]} {each.code}" for each in outcomes)
    longest = max(each.silent_s for each in outcomes)
    report = {"seed": options.seed, "cases": len(outcomes), "codes": dict(sorted(counts.items()))}
    print(json.dumps(report | {"longest_silence_s": longest, "failed": failed}, indent=1))
    sys.exit(1 if failed else 0)


def _run_all(tasks: list[tuple[list[str], Path]]) -> list[Outcome]:
    runner, outcomes = Runner(), []
    for arguments, folder in tasks:
        outcomes.append(runner.run(arguments, folder))
        problems = ", ".join(outcomes[-1].problems)
        sys.stderr.write(f"{outcomes[-1].seconds:6.1f} s, {outcomes[-1].code}: {outcomes[-1].command} {problems}\n")
    runner.close()
    return outcomes


if __name__ == "__main__":
    main()
