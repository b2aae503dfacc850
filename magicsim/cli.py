"""The command line. Every command takes `--json`: one object on stdout, everything else on stderr.

Heavy modules are imported inside the commands, so that `magicsim --help` answers at once.
"""

import json
import logging
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import App, CycloptsError, Parameter

import magicsim
from magicsim.errors import ConfigError, MagicsimError

app = App(
    name="magicsim",
    version=magicsim.__version__,
    help="Simulator of the mini-MagicTac see-through touch sensor.",
    suppress_keyboard_interrupt=False,
)

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout.")]
Settings = Annotated[
    list[str] | None,
    Parameter(name="--set", negative="", help="Override a setting: dotted.key=value; repeatable."),
]
Seed = Annotated[int | None, Parameter(name="--seed", help="Seed of everything random.")]
Threads = Annotated[
    int | None, Parameter(name="--threads", help="Rendering threads; the result does not depend on it.")
]
Out = Annotated[Path, Parameter(name="--out", help="Where the result goes.")]


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
    from magicsim.folder import check_target
    from magicsim.progress import show_progress
    from magicsim.scenes.scene import load_scene

    scene = load_scene(name, settings or [], seed=seed)
    check_target(out)
    _limit_threads(threads)
    from magicsim.run import run_scene

    with show_progress(f"{name}: {scene.references + scene.frame_count} frames") as progress:
        summary = run_scene(scene, out, progress=progress)
    _print(_fields(summary), as_json=as_json)


@app.command
def plan(scene: str, *, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Explain what a scene needs and what is left out, and why."""
    from magicsim.plan import plan_scene
    from magicsim.scenes.scene import load_scene

    planned = plan_scene(load_scene(scene, settings or [], seed=seed))
    _print(
        {
            "kept": [_fields(decision) for decision in planned.kept],
            "left_out": [_fields(decision) for decision in planned.left_out],
        },
        as_json=json,
    )


@app.command
def press(
    design: str, *, object: Annotated[str, Parameter(name="--object", help="KIND:key=value,...")],
    depth_mm: float,
    shear_mm: Annotated[str, Parameter(allow_leading_hyphen=True, help="X,Y after the press.")] = "0,0",
    twist_deg: float = 0.0, friction: float = 0.0,
    speed_mm_s: Annotated[float | None, Parameter(help="Speed, for a path that takes time.")] = None,
    hold_s: Annotated[float, Parameter(help="Time at the end of such a path.")] = 0.0,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Solve one contact: press, then shear, then twist; quasi-static unless a speed is given."""
    from magicsim.config import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.objects import parse_object

    block = load_preset(ElastomerDesign, "design", design, settings or [])
    thing, shear = parse_object(object), _pair("shear_mm", shear_mm)
    from magicsim.deform.press import press as solve

    result = solve(
        block, thing, depth_mm=depth_mm, shear_mm=shear, twist_deg=twist_deg, friction=friction,
        speed_mm_s=speed_mm_s, hold_s=hold_s,
    )  # fmt: skip
    _print(result.as_dict(), as_json=json)


@app.command
def durometer(
    design: str, *, place: Literal["cell", "wall"] = "cell",
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Press a virtual Shore A durometer into a block, on the centre of a cell or where walls cross."""
    from magicsim.config import load_preset
    from magicsim.geometry.design import ElastomerDesign

    del seed  # nothing here is random; the option exists on every command
    block = load_preset(ElastomerDesign, "design", design, settings or [])
    from magicsim.deform.durometer import durometer as test

    _print(_fields(test(block, place=place)), as_json=json)


@app.command
def render(
    scene: str, *, frame: int = 0, estimator: Literal["fluence", "path"] | None = None,
    samples: int | None = None, particles: int | None = None, basis: bool = False,
    relative_error: float | None = None, out: Annotated[Path | None, Parameter(name="--out")] = None,
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Render one linear radiance image of a scene's frame, float32, (rows, columns, 3).

    Without --samples or --particles it takes those of the scene's anchor. --basis renders one image for each light, as
    arrays of an .npz file that `magicsim.scenes.relight` adds up with other strengths. --relative-error averages
    independent images, each with the scene's own samples, until the error estimated from their spread is below it.
    """
    from magicsim.scenes.scene import load_scene

    choices = [f"render.estimator={estimator}"] if estimator is not None else []
    choices += [f"render.samples={samples}"] if samples is not None else []
    choices += [f"render.particles={particles}"] if particles is not None else []
    config = load_scene(scene, [*(settings or []), *choices], seed=seed)
    _limit_threads(threads)
    from magicsim.still import render_still, with_care

    if relative_error is None:
        config = with_care(config, samples=samples is None, particles=particles is None)
    still = render_still(config, frame, out, basis=basis, relative_error=relative_error)
    _print(_fields(still), as_json=json)


@app.command
def detect(
    source: Path, *, reference: Path, profile: str = "calibrated", seed: Seed = None, settings: Settings = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Run the detectors on an image or a folder of images."""
    from magicsim.detectors.cli import as_json, as_table
    from magicsim.detectors.offline import detect_sources

    del seed  # nothing here is random; the option exists on every command
    if settings:
        msg = f"--set {settings[0]} is not allowed with detect; write a profile file and name it with --profile"
        raise ConfigError(msg)
    verdicts = detect_sources(source, reference, profile)
    sys.stdout.write((as_json(verdicts) if json else as_table(verdicts)).rstrip() + "\n")


@app.command
def export(design: str, *, out: Out, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Write a design's printable geometry as STL: the clear part with its cavities, and the infill beside it."""
    from magicsim.config import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.export import export_design

    del seed  # nothing here is random; the option exists on every command
    _print(
        _fields(export_design(load_preset(ElastomerDesign, "design", design, settings or []), out)),
        as_json=json,
    )


@app.command
def calibration(
    scene: str, *, settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Intrinsics, distortion and millimetres per pixel at every layer of a scene's sensor."""
    from magicsim.scenes.calibration import calibrate
    from magicsim.scenes.scene import load_scene

    config = load_scene(scene, settings or [], seed=seed)
    _print(_fields(calibrate(config.design, config.rig)), as_json=json)


@app.command
def bench(
    kind: Literal["deform", "stress", "cost", "render"] = "deform", *, out: Out = Path("magicsim-bench"),
    quick: Annotated[bool, Parameter(negative="", help="A small part of it.")] = False,
    recompute: Annotated[bool, Parameter(negative="", help="Solve the reference again (needs NGSolve).")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Report error against run time of the deformation, its validity at extremes, or cost against size."""
    from magicsim.bench.run import run_bench

    del seed  # the cases' random numbers are fixed; the option exists on every command
    if settings:
        msg = f"--set {settings[0]} is not allowed with bench: its cases are fixed"
        raise ConfigError(msg)
    found = run_bench(kind, out, quick=quick, recompute=recompute)
    _print(found if json else {"results": found["results"], "written": str(out)}, as_json=json)


@app.command
def doctor(*, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Say what this machine can do, and how to get the rest."""
    from magicsim.doctor import examine

    del settings, seed
    _print(_fields(examine()), as_json=json)


@app.command
def schema(
    kind: Literal["design", "scene", "rig", "object", "profile"] = "scene", *, settings: Settings = None,
    seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Print the JSON Schema of a kind of configuration file."""
    from magicsim.schema import schema_of

    del settings, seed, json
    _print(schema_of(kind), as_json=True)


def main() -> None:
    """Entry point: errors are one line on stderr and exit code 2."""
    logging.basicConfig(level=logging.WARNING, format="magicsim: %(message)s", stream=sys.stderr)
    try:
        app(sys.argv[1:], exit_on_error=False, print_error=False)
    except CycloptsError as error:
        _fail(" ".join(str(error).split()))
    except MagicsimError as error:
        _fail(" ".join(str(error).split()))
    except KeyboardInterrupt:
        sys.stderr.write("magicsim: stopped\n")
        sys.exit(130)


def _fail(message: str) -> None:
    sys.stderr.write(f"magicsim: {message}\n")
    sys.exit(2)


def _limit_threads(threads: int | None) -> None:
    if threads is None:
        return
    if threads < 1:
        msg = f"threads = {threads} is not allowed: must be at least 1"
        raise ConfigError(msg)
    from magicsim.scenes.backend import dr

    dr.set_thread_count(threads)


def _pair(name: str, text: str) -> tuple[float, float]:
    parts = text.split(",")
    try:
        x, y = (float(part) for part in parts)
    except ValueError:
        msg = f"{name} = '{text}' is not allowed: must be two numbers X,Y"
        raise ConfigError(msg) from None
    return x, y


def _fields(result: object) -> dict[str, Any]:
    return asdict(result)  # type: ignore[call-overload, no-any-return]


def _print(values: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        sys.stdout.write(json.dumps(values, allow_nan=False) + "\n")
        return
    for key, value in values.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            sys.stdout.write(f"{key}:\n")
            for item in value:
                sys.stdout.write("  " + ": ".join(str(part) for part in item.values()) + "\n")
        else:
            sys.stdout.write(f"{key}: {value}\n")
