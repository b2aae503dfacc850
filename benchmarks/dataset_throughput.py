"""How fast a recipe becomes rows, on one process and on more, what a frame takes on disk, and whether memory is flat.

    python benchmarks/dataset_throughput.py --out throughput [--recipe default] [--episodes 32] [--workers 1 2]
        [--set key=value] [--figures docs/benchmarks/dataset-throughput.json]

Each number of processes makes the same dataset in a folder of its own below `--out`, on as many cores. A run that was
stopped goes on where it was: episodes that are there are not made again, and the time of every run counts. Efficiency
is speed per process against that of the first number. The rate per core is the median over episodes of frames per
second of the process. Memory is that of all processes, taken after every episode.
"""

import argparse
import contextlib
import json
import multiprocessing
import os
import statistics
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from magicsim.dataset.generate import Standing, generate_dataset
from magicsim.dataset.manifest import read_manifest
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.recipe import Recipe, load_recipe
from magicsim.workers.attempt import choose_workers, usable_cores

LOG = "episodes.jsonl"
QUARTERS = (0.25, 0.5, 0.75, 1.0)
"""Shares of the episodes after which memory is told; it has to level off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Throughput:
    """One number of processes."""

    workers: int
    frames: int
    failed: int
    seconds: float
    """Time of all runs together [s]."""
    frames_per_second: float
    median_episode_frames_per_second: float
    """Of one process, over all episodes."""
    median_by_path: dict[str, float]
    """The same for each kind of path [1/s]."""
    kilobytes_per_frame: float
    megabytes_median: float
    """Memory of all processes [MB]."""
    megabytes_peak: float
    megabytes_at_quarters: list[float]
    """Memory after a quarter, half, three quarters and all of the episodes [MB]."""


def measure(recipe: Recipe, out: Path, workers: int) -> None:
    """Makes the dataset, or what is missing of it, on as many cores as processes, and notes every episode."""
    out.mkdir(parents=True, exist_ok=True)
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(cores)[:workers])
    begin = last = time.monotonic()
    with (out / LOG).open("a", encoding="utf-8") as log:

        def note(standing: Standing) -> None:
            nonlocal last
            now = time.monotonic()
            entry = {
                "episode": standing.episode, "frames": standing.episode_frames, "wall_s": now - last,
                "process_s": standing.episode_seconds, "megabytes": megabytes(),
            }  # fmt: skip
            last = now
            log.write(json.dumps(entry) + "\n")
            log.flush()
            print(f"{workers} workers: {standing.done} of {standing.total}, {now - begin:.0f} s", file=sys.stderr)

        try:
            options = choose_workers(workers, timeout_s=recipe.timeout_s)
            generate_dataset(recipe, out / "set", options=options, resume=True, progress=note)
        finally:
            os.sched_setaffinity(0, cores)


def megabytes() -> float:
    """Resident memory of this process and its children [MB]."""
    pids = [os.getpid(), *(each.pid for each in multiprocessing.active_children())]
    pages = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            pages += int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def summary(recipe: Recipe, out: Path, workers: int) -> Throughput:
    """Figures of a dataset that is finished."""
    lines = (out / LOG).read_text(encoding="utf-8").splitlines()
    # A run that was killed may have noted an episode whose rows were lost: the last note counts, the time of all.
    notes = {entry["episode"]: entry for entry in map(json.loads, lines) if entry["frames"]}
    paths = {episode.index: episode.path_kind for episode in draw_episodes(recipe)}
    manifest = read_manifest(out / "set")
    if manifest is None or not manifest.is_complete:
        msg = f"{out / 'set'} is not finished: run the benchmark again"
        raise SystemExit(msg)
    rates = {episode: entry["frames"] / entry["process_s"] for episode, entry in notes.items()}
    by_path = {
        kind: [rate for each, rate in rates.items() if paths[each] == kind] for kind in sorted(set(paths.values()))
    }
    memory = np.array([json.loads(line)["megabytes"] for line in lines])
    seconds = sum(json.loads(line)["wall_s"] for line in lines)
    return Throughput(
        workers=workers,
        frames=manifest.rows,
        failed=len(manifest.failed),
        seconds=round(seconds, 1),
        frames_per_second=round(manifest.rows / seconds, 4),
        median_episode_frames_per_second=round(statistics.median(rates.values()), 4),
        median_by_path={kind: round(statistics.median(each), 4) for kind, each in by_path.items() if each},
        kilobytes_per_frame=round(sum(entry.size for entry in manifest.shards) / max(1, manifest.rows) / 1e3, 1),
        megabytes_median=round(float(np.median(memory))),
        megabytes_peak=round(float(memory.max())),
        megabytes_at_quarters=[round(float(memory[max(0, round(share * len(memory)) - 1)])) for share in QUARTERS],
    )


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recipe", default="default")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--episodes", type=int, default=32)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--figures", type=Path)
    asked = parser.parse_args()
    recipe = load_recipe(asked.recipe, [*asked.settings, f"episodes={asked.episodes}"])
    for workers in asked.workers:
        measure(recipe, asked.out / str(workers), workers)
    results = [summary(recipe, asked.out / str(workers), workers) for workers in asked.workers]
    each = [result.frames_per_second / result.workers for result in results]
    found = {
        "recipe": asked.recipe, "settings": asked.settings, "cores": usable_cores(),
        "efficiency": [round(rate / each[0], 3) for rate in each], "results": [asdict(result) for result in results],
    }  # fmt: skip
    text = json.dumps(found, indent=1)
    print(text)
    if asked.figures:
        asked.figures.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
