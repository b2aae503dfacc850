"""The command that renders one radiance image: `render`."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, Threads, app, fields_of, limit_threads, print_result


@app.command
def render(
    scene: str, *, frame: int = 0, estimator: Literal["fluence", "path"] | None = None,
    samples: int | None = None, particles: int | None = None, basis: bool = False,
    relative_error: float | None = None, out: Annotated[Path | None, Parameter(name="--out")] = None,
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Render one linear radiance image of a scene's frame, float32, (rows, columns, 3).

    Without --samples or --particles it takes those of the scene's anchor. --basis renders one image for each light, as
    arrays of an .npz file that `magicsim.light.relight` adds up with other strengths. --relative-error averages
    independent images, each with the scene's own samples, until the error estimated from their spread is below it.
    """
    from magicsim.scenes.scene import load_scene

    choices = [f"render.estimator={estimator}"] if estimator is not None else []
    choices += [f"render.samples={samples}"] if samples is not None else []
    choices += [f"render.particles={particles}"] if particles is not None else []
    config = load_scene(scene, [*(settings or []), *choices], seed=seed)
    limit_threads(threads)
    from magicsim.cli.progress import show_progress
    from magicsim.simulation.still import render_still, with_care

    if relative_error is None:
        config = with_care(config, samples=samples is None, particles=particles is None)
    with show_progress(f"{scene}: frame {frame}"):
        still = render_still(config, frame, out, basis=basis, relative_error=relative_error)
    print_result(fields_of(still), as_json=json)
