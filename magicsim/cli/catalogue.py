"""Commands that help to find one's way: `list`, `completion`."""

import sys
from typing import Annotated, Literal

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, app, fields_of, print_object
from magicsim.config.presets import entries, plurals


@app.command(name="list")
def list_presets(
    kind: Annotated[str | None, Parameter(help="One kind, such as designs; all by default.")] = None,
    *, settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """List what comes with the program, a line each: designs, objects, scenes, rigs, recipes, sweeps, studies, ..."""
    kinds = [kind] if kind is not None else list(plurals())
    found = {each: entries(each) for each in kinds}
    if json:
        print_object({each: [fields_of(entry) for entry in found[each]] for each in kinds}, on_one_line=True)
        return
    width = max((len(entry.name) for each in kinds for entry in found[each]), default=0)
    for each in kinds:
        heading = [f"{each}:\n"] if kind is None else []
        sys.stdout.writelines([*heading, *(f"{entry.name:{width}}  {entry.description}\n" for entry in found[each])])


@app.command
def completion(
    shell: Literal["bash", "zsh", "fish", "powershell"] = "bash", *,
    install: Annotated[bool, Parameter(negative="", help="Write it where the shell looks, and say where.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Print the script that lets a shell complete commands and options; --install puts it in its place."""
    if install:
        place = str(app.install_completion(shell=shell))
        sys.stdout.write(f"{place}\n") if not json else print_object({"shell": shell, "file": place}, on_one_line=True)
        return
    script = app.generate_completion(shell=shell)
    if json:
        print_object({"shell": shell, "script": script}, on_one_line=True)
    else:
        sys.stdout.write(script)
