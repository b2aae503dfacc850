"""Commands that answer questions about the program and its presets: `info list`, `info doctor`, `info schema`, ..."""

import sys
from typing import Annotated, Literal

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Seed, Settings, app, fields_of, print_object, print_result
from magicsim.config.presets import entries, plurals
from magicsim.errors import ConfigError

info_app = App(name="info", help="What comes with the program, what this machine can do, what files look like.")
app.command(info_app)


@info_app.command
def doctor(
    *, clear_cache: Annotated[bool, Parameter(negative="", help="Remove kept sensors, takes and frames.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Say what this machine can do, how to get the rest, and what is kept on disk."""
    from magicsim.cli.doctor import examine

    print_result(examine(clear_cache=clear_cache), as_json=json)


@info_app.command
def schema(
    kind: Literal[
        "design", "scene", "rig", "object", "recipe", "profile", "suite", "sweep", "study", "item", "real",
    ] = "scene", *,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Print the JSON Schema of a kind of configuration file."""
    from magicsim.cli.schema import schema_of

    print_object(schema_of(kind), on_one_line=json)


@info_app.command(name="list")
def list_presets(
    kind: Annotated[str | None, Parameter(help="One kind, such as designs; all by default.")] = None,
    *, settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """List what comes with the program, a line each: designs, objects, scenes, rigs, recipes, sweeps, studies, ..."""
    kinds = [kind] if kind is not None else list(plurals())
    found = {each: entries(each) for each in kinds}
    if json:
        print_result({each: [fields_of(entry) for entry in found[each]] for each in kinds}, as_json=True)
        return
    width = max((len(entry.name) for each in kinds for entry in found[each]), default=0)
    for each in kinds:
        heading = [f"{each}:\n"] if kind is None else []
        sys.stdout.writelines([*heading, *(f"{entry.name:{width}}  {entry.description}\n" for entry in found[each])])


@info_app.command
def completion(
    shell: Literal["bash", "zsh", "fish", "powershell"] = "bash", *,
    install: Annotated[bool, Parameter(negative="", help="Write it where the shell looks, and say where.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Print the script that lets a shell complete commands and options; --install puts it in its place."""
    if install:
        try:
            place = str(app.install_completion(shell=shell))
        except RuntimeError:
            raise ConfigError("install is not allowed: there is no home folder; set HOME") from None
        sys.stdout.write(f"{place}\n") if not json else print_result({"shell": shell, "file": place}, as_json=True)
        return
    script = app.generate_completion(shell=shell)
    if json:
        print_result({"shell": shell, "script": script}, as_json=True)
    else:
        sys.stdout.write(script)


@info_app.command
def camera(
    scene: str, *, settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Intrinsics, distortion and millimetres per pixel at every layer of a scene's sensor."""
    from magicsim.camera.projection import calibrate_camera
    from magicsim.scenes.scene import load_scene

    config = load_scene(scene, settings or [], seed=seed)
    print_result(calibrate_camera(config.design, config.rig), as_json=json)


@app.command(show=False)
def bench(*words: Annotated[str, Parameter(allow_leading_hyphen=True)]) -> None:
    """Say where the benchmarks are."""
    kind = next((word for word in words if word in {"stress", "cost", "render"}), "deform")
    raise ConfigError(f"bench is a script of the repository now: python benchmarks/{kind}.py")
