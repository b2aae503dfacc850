"""Commands of one scene: `simulate`, `simulate plan`, which says what that needs, `render` and `live`."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Seed, Settings, Threads, Tier, app, limit_threads, print_result, with_tier
from magicsim.errors import ConfigError

simulate_app = App(name="simulate")
app.command(simulate_app)
LOWEST_PORT, HIGHEST_PORT = 1024, 65000


@simulate_app.default
def simulate(
    scene: str = "demo", *, out: Annotated[Path | None, Parameter(name="--out")] = None,
    mcap: Annotated[bool, Parameter(negative="", help="Write episode.mcap too; sets output.mcap.")] = False,
    tier: Tier = None, settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Simulate a scene, a file or a preset: frames, ground truth, verdicts, report.

    `demo` is the main job on defaults: approach, touch, press, shear, release, flashlight.
    """
    from magicsim.cli.foresight import check_memory, long_work
    from magicsim.cli.progress import show_progress
    from magicsim.folder import MARKER, check_target
    from magicsim.scenes.scene import load_scene

    out = out or Path(f"magicsim-{Path(scene).stem}")
    config = load_scene(scene, [*with_tier(settings, tier), *(["output.mcap=true"] if mcap else [])], seed=seed)
    check_target(out)
    check_memory(config)
    if config.output.mcap:
        from magicsim.report.episode_report import load_mcap

        load_mcap()  # what is missing is told before anything is rendered
    if (out / MARKER).is_file():
        sys.stderr.write(
            f"'{out}' holds an earlier result: it stays until the new one is whole, and is then replaced\n"
        )
    if (line := long_work(config)) is not None:
        sys.stderr.write(f"{line}\n")
    limit_threads(threads)
    from magicsim.simulation.main_job import run_scene

    with show_progress(f"{scene}: {config.references + config.frame_count} frames") as progress:
        summary = run_scene(config, out, progress=progress)
    print_result(summary, as_json=json)


@simulate_app.command
def plan(scene: str, *, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Explain what a scene needs and what is left out, and why; warn of what does not fit the block.

    The name or file of a design stands for the demo's scene on that design.
    """
    from magicsim.scenes.field_check import field_warnings
    from magicsim.scenes.scene import load_scene
    from magicsim.simulation.plan import plan_scene

    name, more = _scene_of(scene)
    loaded = load_scene(name, [*more, *(settings or [])], seed=seed)
    if loaded.object is not None:
        loaded.object.shape()  # a missing file is an error here, not after the sensor has been rendered
    planned = plan_scene(loaded)
    print_result(
        {
            "kept": [asdict(decision) for decision in planned.kept],
            "left_out": [asdict(decision) for decision in planned.left_out],
            "warnings": field_warnings(loaded),
        },
        as_json=json,
    )


def _scene_of(name: str) -> tuple[str, list[str]]:
    """A scene and settings of it: the scene of that name, or the demo on the design of that name."""
    from magicsim.config.documents import read_toml
    from magicsim.config.presets import find_preset, preset_names

    if name not in preset_names("scene") and name in preset_names("design"):
        return "demo", [f"design={name}"]
    if name.endswith(".toml") and "cell_mm" in read_toml(find_preset("scene", name)):
        return "demo", [f"design={Path(name).expanduser().absolute().as_posix()}"]
    return name, []


@app.command
def render(
    scene: str, *, frame: int = 0, estimator: Literal["fluence", "path"] | None = None,
    samples: int | None = None, particles: int | None = None, basis: bool = False,
    relative_error: float | None = None, out: Annotated[Path | None, Parameter(name="--out")] = None,
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Render one linear radiance image of a scene's frame, float32, (rows, columns, 3).

    Without --particles it takes the anchor's, without --samples 32 of them at most. --basis renders one image for each
    light, as arrays of an .npz file that `magicsim.light.relight` adds up with other strengths. --relative-error
    averages independent images, each with the scene's own samples, until the error estimated from their spread is
    below it.
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
    print_result(still, as_json=json)


@app.command
def live(
    subject: str, *, object: Annotated[str | None, Parameter(name="--object", help="KIND:key=value,...")] = None,
    quality: Annotated[str, Parameter(help="control, or full: slower and finer.")] = "control",
    out: Annotated[Path, Parameter(name="--out", help="Where recordings go.")] = Path("magicsim-live"),
    port: Annotated[int, Parameter(help="Where to listen, on 127.0.0.1 alone.")] = 8321,
    browser: Annotated[bool, Parameter(negative="--no-browser", help="Open the page.")] = True,
    tier: Tier = None, settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Open a window on a scene or a design: drag and press the object, see frame, lattice, force and verdicts."""
    from magicsim.live.session import find_subject

    if not LOWEST_PORT <= port <= HIGHEST_PORT:
        raise ConfigError(f"port = {port} is not allowed: must be {LOWEST_PORT} to {HIGHEST_PORT}")
    scene = find_subject(subject, with_tier(settings, tier), seed=seed, object=object)
    limit_threads(threads)
    from magicsim.live.window import LiveWindow

    def told(line: str) -> None:
        sys.stderr.write(f"{subject}: {line}\n")

    with LiveWindow(scene, folder=out, port=port, quality=quality, told=told) as window:
        if json:
            print_result({"address": window.address}, as_json=True)
        else:
            sys.stdout.write(f"{window.address} (Ctrl-C ends it; recordings go to {out})\n")
        sys.stdout.flush()
        if browser:
            import webbrowser

            webbrowser.open(window.address)
        window.wait()
