"""What becomes of results, and of a user's files, when things go wrong: kills, corruption, rivals, full disks.

    python benchmarks/faults.py kills --count 20
    python benchmarks/faults.py corruption --count 200
    python benchmarks/faults.py rivals --count 50
    python benchmarks/faults.py foreign --count 100
    python benchmarks/faults.py surroundings
    python benchmarks/faults.py live --count 2000
    python benchmarks/faults.py table

Each part runs small but whole commands in folders of its own, and keeps its rows in `--figures`
(docs/benchmarks/faults.json); `table` prints them all. A row counts how often something was tried and how often it went
wrong. The exit code is 1 where anything did.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path

from laboratory.fault_commands import Command, commands, content

from magicsim.dataset.verify import verify_dataset
from magicsim.errors import OutputError
from magicsim.folder.listing import sealed

FIGURES = Path("docs/benchmarks/faults.json")
NO_MOUNT = "this machine allows no mount"
FINISHED, REFUSED = 0, 2
"""Exit codes."""


@dataclass(slots=True, kw_only=True)
class Row:
    """One kind of fault."""

    fault: str
    tried: int = 0
    wrong: list[str] = field(default_factory=list)
    """What went wrong, a line each."""
    note: str = ""

    def check(self, *, holds: bool, otherwise: str) -> None:
        """Counts a trial."""
        self.tried += 1
        if not holds:
            self.wrong.append(otherwise)


def kills(work: Path, count: int, chance: random.Random) -> Iterator[Row]:
    """Random SIGKILLs; then another run, whose bytes are those of an undisturbed one."""
    for name, command in commands(work).items():
        row = Row(fault=f"SIGKILL at a random moment of `{name}`, then {'--resume' if command.again else 'again'}")
        start = time.monotonic()
        whole = work / f"{name}-whole"
        _finish(command, whole)
        long_s, expected = time.monotonic() - start, content(whole)
        done = 0
        while row.tried < count:
            out = work / f"{name}-{done}"
            is_resumed = out.exists()
            run = command.start(out, resume=is_resumed)
            time.sleep(chance.uniform(0.3, 1.1 * long_s))
            run.kill()
            ended = run.wait() == FINISHED
            told = run.stderr.read() if run.stderr is not None else ""
            row.check(holds="Traceback" not in told, otherwise=f"run {row.tried}: {told[-300:]}")
            if not command.again and (out / ".magicsim.json").exists():
                row.check(holds=content(out) == expected, otherwise=f"run {row.tried}: a half result under its name")
            if ended or row.tried >= count:
                _finish(command, out, resume=bool(command.again))
                if content(out) != expected:
                    row.wrong.append(f"{out.name}: other bytes: {_difference(content(out), expected)}")
                done += 1
        left = [path.name for path in work.iterdir() if path.name.startswith(f".{name}-")]
        row.note = f"{done} folders finished, bytes compared; {len(left)} working folders left"
        yield row


def _finish(command: Command, out: Path, *, resume: bool = False) -> None:
    ended = command.run(out, resume=resume)
    if ended.returncode != FINISHED:
        msg = f"{command.name} into {out.name}: exit code {ended.returncode}: {ended.stderr[-500:]}"
        raise SystemExit(msg)


def _difference(one: dict[str, str], other: dict[str, str]) -> list[str]:
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))


def corruption(work: Path, count: int, chance: random.Random) -> Iterator[Row]:
    """Changes to a finished dataset, each of which `verify` tells."""
    whole = work / "whole"
    _finish(commands(work)["dataset"], whole)
    row = Row(fault="a dataset changed: bits, bytes, length, missing and additional files, values of the manifest")
    for number in range(count):
        copy = shutil.copytree(whole, work / "copy")
        change = chance.choice((_flip, _flip, _flip, _cut, _append, _remove, _add, _edit, _swap))(copy, chance)
        try:
            told = verify_dataset(copy).problems
        except OutputError as error:
            told = [str(error)]
        row.check(holds=bool(told), otherwise=f"{number}: {change}")
        shutil.rmtree(copy)
    yield row


def _some_file(folder: Path, chance: random.Random) -> Path:
    return chance.choice(sorted(path for path in folder.rglob("*") if path.is_file()))


def _flip(folder: Path, chance: random.Random) -> str:
    path = _some_file(folder, chance)
    data, place = bytearray(path.read_bytes()), chance.randrange(8 * path.stat().st_size)
    data[place // 8] ^= 1 << place % 8
    path.write_bytes(data)
    return f"bit {place} of {path.name}"


def _cut(folder: Path, chance: random.Random) -> str:
    path = _some_file(folder, chance)
    path.write_bytes(path.read_bytes()[: chance.randrange(path.stat().st_size)])
    return f"{path.name} cut off"


def _append(folder: Path, chance: random.Random) -> str:
    path = _some_file(folder, chance)
    path.write_bytes(path.read_bytes() + chance.choice((b"\n", b" ", b"\0", b"{}")))
    return f"{path.name} is longer"


def _remove(folder: Path, chance: random.Random) -> str:
    path = _some_file(folder, chance)
    path.unlink()
    return f"{path.name} removed"


def _add(folder: Path, chance: random.Random) -> str:
    name = chance.choice(("a.txt", ".a", "data/a.parquet", "data/sub/x.parquet", "sub/a/b", ".work/a", "data/.a.tmp"))
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(b"more")
    return f"{name} added"


def _edit(folder: Path, chance: random.Random) -> str:
    """A value of the manifest changed, half of the times with a new hash."""
    path = folder / "manifest.json"
    values = json.loads(path.read_text())
    change = chance.choice((
        {"seed": 99}, {"episodes": 7}, {"is_complete": False}, {"rows": 1}, {"config_hash": "0" * 64},
        {"failed": [{"episode": 0, "kind": "refused", "message": "no"}]},
        {"shards": [{**values["shards"][0], "split": "other"}, *values["shards"][1:]]},
        {"shards": [{**values["shards"][0], "file": "../a.parquet"}, *values["shards"][1:]]},
    ))  # fmt: skip
    is_sealed = chance.random() < 0.5
    path.write_bytes(sealed(values | change) if is_sealed else json.dumps(values | change, indent=1).encode() + b"\n")
    return f"manifest: {next(iter(change))}{' with a new hash' if is_sealed else ''}"


def _swap(folder: Path, chance: random.Random) -> str:
    one, other = chance.sample(sorted((folder / "data").glob("*.parquet")), 2)
    first, second = one.read_bytes(), other.read_bytes()
    one.write_bytes(second)
    other.write_bytes(first)
    return f"{one.name} and {other.name} swapped"


def rivals(work: Path, count: int, chance: random.Random) -> Iterator[Row]:
    """Two runs into one folder at almost the same time: the one refuses, or comes after the other."""
    known = commands(work)
    for name, share in (("simulate", 0.6), ("dataset", 0.2), ("sweep", 0.2)):
        command, out = known[name], work / f"{name}-shared"
        _finish(command, work / f"{name}-whole")
        expected = content(work / f"{name}-whole")
        row = Row(fault=f"two `{name}` into one folder")
        refused = 0
        for number in range(max(1, round(share * count))):
            first = command.start(out)
            time.sleep(chance.choice((0.0, 0.05, 0.5, 2.0)))
            second = command.start(out)
            ends = [(run.communicate()[1], run.returncode) for run in (first, second)]
            codes = sorted(code for _, code in ends)
            refused += codes == [FINISHED, REFUSED]
            told = "; ".join(text.strip().splitlines()[-1] for text, code in ends if code != FINISHED)
            holds = codes[0] == FINISHED and codes[1] in {FINISHED, REFUSED} and content(out) == expected
            row.check(holds=holds, otherwise=f"{number}: exit codes {codes}; {told}")
            if name != "simulate":
                shutil.rmtree(out)
        row.note = f"in {refused} the second was told that the folder is being written"
        yield row


PLACES = (
    "{out}/notes.txt", "{out}/.hidden", "{out}/frames/mine.png", "{out}/data/mine.parquet", "{out}/sub/a/b",
    "{out}/.work/notes.txt", "{out}/.mine.tmp", "{out}/data/.mine.tmp", "{out}/designs/mine.json",
    "{out}/preview.png", "{near}/.{name}.partial/thesis.txt", "{near}/.{name}.tmp", "{near}/{name}.txt",
    "{near}/.{name}.lock", "{near}/.{name}.0123456789abcdef.partial/thesis.txt", "{near}/.{name}.magicsim-lock",
)  # fmt: skip
"""Where somebody's own files may be."""


def foreign(work: Path, count: int, chance: random.Random) -> Iterator[Row]:
    """Somebody's files in and near output folders: all still there, and named where they are in the way."""
    known = commands(work)
    preview = Command(name="preview", arguments=(*known["dataset"].arguments, "--preview", "2"))
    runs = (*known.values(), preview)
    wholes = {}
    for command in runs:
        wholes[command.name] = work / "wholes" / command.name
        _finish(command, wholes[command.name])
    row = Row(fault="somebody's file in or near an output folder")
    refused = 0
    for number in range(count):
        command = runs[number % len(runs)]
        out = work / f"{number}" / "out"
        out.parent.mkdir()
        if chance.random() < 0.7:
            shutil.copytree(wholes[command.name], out)
        else:
            out.mkdir()
        mine = Path(chance.choice(PLACES).format(out=out, near=out.parent, name=out.name))
        before = f"mine {number}".encode()
        mine.parent.mkdir(parents=True, exist_ok=True)
        mine.write_bytes(before)
        ended = command.run(out, resume=bool(command.again))
        refused += ended.returncode == REFUSED
        kept = mine.is_file() and mine.read_bytes() == before
        fine = ended.returncode in {FINISHED, REFUSED} and "Traceback" not in ended.stderr
        row.check(holds=kept and fine, otherwise=f"{command.name}, {mine.relative_to(work)}: {ended.stderr[-200:]}")
        shutil.rmtree(out.parent)
    row.note = f"{refused} refused, which names the file; the others did not meet it"
    yield row


@contextmanager
def _mounted(folder: Path, options: str) -> Iterator[bool]:
    """A small disk of its own in memory at a folder; False where this machine does not let one be made."""
    folder.mkdir(parents=True, exist_ok=True)
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)], capture_output=True, check=False
    )
    try:
        yield made.returncode == 0
    finally:
        if made.returncode == 0:
            subprocess.run(["umount", "-l", str(folder)], check=True)


def surroundings(work: Path, count: int, chance: random.Random) -> Iterator[Row]:
    """Disks and machines that fail: full, read-only, a mount point as output folder, a cluster that goes away."""
    del count, chance
    known = commands(work)
    for command in known.values():
        yield from _disks(work / command.name, command)
    yield from _cluster(work, known["dataset"])


def _disks(work: Path, command: Command) -> Iterator[Row]:
    work.mkdir()
    _finish(command, work / "whole")
    expected = content(work / "whole")
    with _mounted(work / "disk", "size=40k") as is_mounted:
        row = Row(fault=f"full disk, `{command.name}`", note="" if is_mounted else NO_MOUNT)
        if is_mounted:
            ended = command.run(work / "disk" / "out")
            row.check(holds=_is_one_line(ended), otherwise=ended.stderr[-300:])
            if not command.again:
                row.check(holds=not (work / "disk" / "out").exists(), otherwise="something is left under the name")
                left = [path.name for path in (work / "disk").iterdir() if not path.name.endswith("--cache")]
                row.check(holds=not left, otherwise=f"left: {left}")
            else:
                subprocess.run(["mount", "-o", "remount,size=40m", str(work / "disk")], check=True)
                _finish(command, work / "disk" / "out", resume=True)
                row.check(holds=content(work / "disk" / "out") == expected, otherwise="other bytes after --resume")
    yield row
    with _mounted(work / "read-only", "size=1m") as is_mounted:
        row = Row(fault=f"read-only disk, `{command.name}`", note="" if is_mounted else NO_MOUNT)
        if is_mounted:
            subprocess.run(["mount", "-o", "remount,ro", str(work / "read-only")], check=True)
            start = time.monotonic()
            ended = command.run(work / "read-only" / "out")
            row.check(holds=_is_one_line(ended), otherwise=ended.stderr[-300:])
            row.note = f"told after {time.monotonic() - start:.1f} s"
    yield row
    with _mounted(work / "mount", "size=40m") as is_mounted:
        row = Row(fault=f"mount point as output folder, `{command.name}`", note="" if is_mounted else NO_MOUNT)
        if is_mounted:
            for _ in range(2):
                _finish(command, work / "mount", resume=bool(command.again))
                row.check(holds=content(work / "mount") == expected, otherwise="other bytes")
            (work / "mount" / "notes.txt").write_text("mine")
            ended = command.run(work / "mount", resume=bool(command.again))
            kept = (work / "mount" / "notes.txt").is_file()
            row.check(holds=_is_one_line(ended) and kept, otherwise=ended.stderr[-300:])
    yield row


def _is_one_line(ended: subprocess.CompletedProcess[str]) -> bool:
    last = ended.stderr.strip().splitlines()[-1]
    return ended.returncode == REFUSED and last.startswith("magicsim: ") and "Traceback" not in ended.stderr


def _cluster(work: Path, command: Command) -> Iterator[Row]:
    """A dask.distributed worker that is killed costs nothing; without its scheduler a run ends in one line."""
    _finish(command, work / "alone")
    expected = content(work / "alone")
    for victim in ("worker", "scheduler"):
        row = Row(fault=f"the {victim} of a cluster goes away, `dataset --cluster`")
        with _running(work / "scheduler.json") as (scheduler, workers, address):
            arguments = [part for part in command.arguments if part not in {"--workers", "2"}]
            away = Command(name="cluster", arguments=(*arguments, "--cluster", address), again=("--resume",))
            run = away.start(work / f"cluster-{victim}")
            while not list((work / f"cluster-{victim}").glob(".work/episode-*")) and run.poll() is None:
                time.sleep(0.1)
            os.killpg((workers[0] if victim == "worker" else scheduler).pid, signal.SIGKILL)
            start = time.monotonic()
            told = run.communicate(timeout=900)[1]
            took_s = time.monotonic() - start
        if victim == "worker":
            row.check(holds=run.returncode == FINISHED, otherwise=told[-300:])
        else:
            last = told.strip().splitlines()[-1]
            row.check(holds=run.returncode == REFUSED and last.startswith("magicsim: "), otherwise=told[-300:])
            row.note = f"told after {took_s:.0f} s: {last[:120]}"
            _finish(command, work / f"cluster-{victim}", resume=True)
        row.check(holds=content(work / f"cluster-{victim}") == expected, otherwise="other bytes")
        yield row


@contextmanager
def _running(file: Path) -> Iterator[tuple[subprocess.Popen[bytes], list[subprocess.Popen[bytes]], str]]:
    """A scheduler and two workers as processes of their own, and the scheduler's address."""
    file.unlink(missing_ok=True)
    dask = [sys.executable, "-m", "distributed.cli"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
    scheduler = subprocess.Popen(
        [*dask[:2], "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
         "--scheduler-file", str(file)], **quiet,
    )  # fmt: skip
    while not file.exists():
        time.sleep(0.1)
    address = json.loads(file.read_text())["address"]
    workers = [
        subprocess.Popen(
            [*dask[:2], "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"], **quiet
        )
        for _ in range(2)
    ]
    try:
        yield scheduler, workers, address
    finally:
        for each in (*workers, scheduler):
            with suppress(ProcessLookupError):
                os.killpg(each.pid, signal.SIGKILL)
            each.wait()


LIVE = ("design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=24", "rig.camera.rows=32",
        "rig.camera.field_mm=10", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
        "render.anchor_particles=2000", "object.radius_mm=3")  # fmt: skip
WARM_SHARE, MOST_GROWTH = 0.25, 1.05
"""Memory after so much of the frames is what it may grow from, by so much at most."""


def live(work: Path, count: int, chance: random.Random) -> Iterator[Row]:
    """A live sensor through mixed states: near, pressed, sheared, lit, without object; its memory stays flat."""
    del work
    from magicsim.errors import MagicsimError
    from magicsim.robot import live_sensor

    row, megabytes = Row(fault="frames of a live sensor in mixed states"), []
    with live_sensor("grip", LIVE) as sensor:
        for number in range(count):
            try:
                kind = chance.random()
                if kind < 0.1:
                    sensor.remove_object()
                elif kind < 0.2:
                    sensor.shine(on=chance.random() < 0.5, x_mm=chance.uniform(-3, 3))
                else:
                    x_mm, y_mm = chance.uniform(-2, 2), chance.uniform(-2, 2)
                    sensor.move_to(gap_mm=chance.choice((3.0, 0.3, -0.1, -0.4, -0.8)), x_mm=x_mm, y_mm=y_mm)
                image = sensor.frame().image
                row.check(holds=image.shape == (32, 24, 3), otherwise=f"frame {number}: shape {image.shape}")
            except MagicsimError as error:  # a refusal is an answer
                row.check(holds="\n" not in str(error), otherwise=f"frame {number}: {error}")
            if number % max(1, count // 20) == 0:
                megabytes.append(_resident_mb())
    warm = megabytes[int(len(megabytes) * WARM_SHARE)]
    row.check(holds=megabytes[-1] < MOST_GROWTH * warm, otherwise=f"memory grew: {megabytes}")
    row.note = f"memory {warm:.0f} MB after a quarter of them, {megabytes[-1]:.0f} MB at the end"
    yield row


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


PARTS: dict[str, Callable[[Path, int, random.Random], Iterator[Row]]] = {
    "kills": kills,
    "corruption": corruption,
    "rivals": rivals,
    "foreign": foreign,
    "surroundings": surroundings,
    "live": live,
}


def table(rows: dict[str, list[dict[str, object]]]) -> str:
    """All rows for the documentation."""
    lines = ["| fault | tried | went wrong | |", "|---|---|---|---|"]
    for part in rows.values():
        lines += [f"| {row['fault']} | {row['tried']} | {len(row['wrong'])} | {row['note']} |" for row in part]
    return "\n".join(lines)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=[*PARTS, "table"])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--figures", type=Path, default=FIGURES)
    parser.add_argument("--work", type=Path, help="folder of the runs, which goes afterwards")
    chosen = parser.parse_args()
    known = json.loads(chosen.figures.read_text()) if chosen.figures.exists() else {}
    if chosen.part == "table":
        print(table(known))
        return
    if chosen.work is not None:
        chosen.work.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=chosen.work) as work:
        found = []
        for row in PARTS[chosen.part](Path(work), chosen.count, random.Random(chosen.seed)):
            print(json.dumps(asdict(row)), flush=True)
            found.append(asdict(row))
    known[chosen.part] = found
    chosen.figures.write_text(json.dumps(known, indent=1) + "\n")
    sys.exit(any(row["wrong"] for row in found))


if __name__ == "__main__":
    main()
