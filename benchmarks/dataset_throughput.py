"""How fast a recipe becomes rows, on one process and on more, what a frame takes on disk, and whether memory is flat.

    python benchmarks/dataset_throughput.py [--recipe default] [--episodes 75] [--workers 1 2] [--set key=value]

Each number of processes shares all cores; efficiency is speed per process against that of the first number. The rate
per core is the median over episodes of frames per second, in processes of one thread each (workers = cores).
"""

import argparse
import json
import resource
import statistics
import tempfile
from pathlib import Path

from magicsim.dataset.generate import Standing, generate_dataset
from magicsim.dataset.recipe import Recipe, load_recipe
from magicsim.workers.options import choose_workers, usable_cores


def measure(recipe: Recipe, workers: int) -> dict[str, object]:
    """One run into a temporary folder."""
    rates: list[float] = []

    def note(standing: Standing) -> None:
        if standing.episode_frames:
            rates.append(standing.episode_frames / standing.episode_seconds)

    with tempfile.TemporaryDirectory() as folder:
        options = choose_workers(workers, timeout_s=recipe.timeout_s)
        found = generate_dataset(recipe, Path(folder) / "set", options=options, progress=note)
    return {
        "workers": workers,
        "threads": options.threads,
        "frames": found.samples,
        "failed": found.failed,
        "seconds": found.seconds,
        "frames_per_second": found.frames_per_second,
        "median_episode_frames_per_second": round(statistics.median(rates), 4) if rates else 0.0,
        "kilobytes_per_frame": round(found.bytes / max(1, found.samples) / 1e3, 1),
        "peak_process_megabytes": round(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3),
    }


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recipe", default="default")
    parser.add_argument("--episodes", type=int, default=75)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--set", action="append", default=[], dest="settings")
    asked = parser.parse_args()
    recipe = load_recipe(asked.recipe, [*asked.settings, f"episodes={asked.episodes}"])
    results = [measure(recipe, workers) for workers in asked.workers]
    first = results[0]
    for result in results:
        gain = float(result["frames_per_second"]) / float(first["frames_per_second"])  # type: ignore[arg-type]
        result["efficiency"] = round(gain * int(first["workers"]) / int(result["workers"]), 3)  # type: ignore[call-overload]
    print(json.dumps({"cores": usable_cores(), "results": results}))


if __name__ == "__main__":
    main()
