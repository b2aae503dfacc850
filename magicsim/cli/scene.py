"""Commands that take a scene: `demo`, `simulate`, `plan`."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, Threads, app, fields_of, limit_threads, print_result


@app.command
def demo(
    *, out: Out = Path("magicsim-demo"), settings: Settings = None, seed: Seed = None, threads: Threads = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Run the main job on defaults: approach, touch, press, shear, release, flashlight; frames, verdicts, report."""
    _run("demo", out, settings, seed, threads, as_json=json)


@app.command
def simulate(
    scene: str, *, out: Annotated[Path | None, Parameter(name="--out")] = None, settings: Settings = None,
    seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Simulate any scene file or preset: frames, ground truth, verdicts, report."""
    _run(scene, out or Path(f"magicsim-{Path(scene).stem}"), settings, seed, threads, as_json=json)


def _run(
    name: str, out: Path, settings: list[str] | None, seed: int | None, threads: int | None, *, as_json: bool
) -> None:
    from magicsim.cli.foresight import check_memory, long_work
    from magicsim.cli.progress import show_progress
    from magicsim.folder import check_target
    from magicsim.scenes.scene import load_scene

    scene = load_scene(name, settings or [], seed=seed)
    check_target(out)
    check_memory(scene)
    if (line := long_work(scene)) is not None:
        sys.stderr.write(f"{line}\n")
    limit_threads(threads)
    from magicsim.report.main_job import run_scene

    with show_progress(f"{name}: {scene.references + scene.frame_count} frames") as progress:
        summary = run_scene(scene, out, progress=progress)
    print_result(fields_of(summary), as_json=as_json)


@app.command
def plan(scene: str, *, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Explain what a scene needs and what is left out, and why."""
    from magicsim.scenes.scene import load_scene
    from magicsim.simulation.plan import plan_scene

    loaded = load_scene(scene, settings or [], seed=seed)
    if loaded.object is not None:
        loaded.object.shape()  # a missing file is an error here, not after the sensor has been rendered
    planned = plan_scene(loaded)
    print_result(
        {
            "kept": [fields_of(decision) for decision in planned.kept],
            "left_out": [fields_of(decision) for decision in planned.left_out],
        },
        as_json=json,
    )
