"""The commands that play a task of the gripper: `task assembly`."""

import sys
from typing import Annotated

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, Threads, app, fields_of, limit_threads, print_result

task_app = App(name="task", help="Play a task with two sensors on a gripper.")
app.command(task_app)


@task_app.command
def assembly(
    scene: str = "assembly", *, out: Out,
    trials: Annotated[int, Parameter(help="How many; a third each beside the axis, at an angle, aligned.")] = 16,
    quality: Annotated[str, Parameter(help="control, or full: slower and finer.")] = "control",
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Plug a held plug into a base in six stages, and tell who notices that the base is misaligned."""
    from magicsim.scenes.scene import load_scene

    loaded = load_scene(scene, settings or [], seed=seed)
    limit_threads(threads)
    from magicsim.robot.assembly.run import run_assembly

    def told(line: str) -> None:
        sys.stderr.write(f"magicsim: {line}\n")

    summary = run_assembly(loaded, out, trials=trials, seed=loaded.seed, quality=quality, told=told)
    print_result(fields_of(summary), as_json=json)
