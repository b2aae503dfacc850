"""Commands about the program itself: `bench`, `doctor`, `schema`."""

import logging
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, app, fields_of, print_object, print_result, refuse_settings

Kind = Literal["deform", "stress", "cost", "render", "all"]


@app.command
def bench(
    kind: Kind = "deform", *, out: Out = Path("magicsim-bench"),
    quick: Annotated[bool, Parameter(negative="", help="A small part of it.")] = False,
    recompute: Annotated[bool, Parameter(negative="", help="Solve the reference again (needs NGSolve).")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Report error against run time of deformation and light, validity at extremes, and cost against size."""
    from magicsim.bench.kinds import run_bench

    refuse_settings(settings, "bench", ": its cases are fixed")
    logging.getLogger("magicsim.bench").setLevel(logging.INFO)  # each row as it is measured, on stderr
    found = run_bench(kind, out, quick=quick, recompute=recompute)
    print_result(found if json else {"results": found["results"], "written": str(out)}, as_json=json)


@app.command
def doctor(
    *, clear_cache: Annotated[bool, Parameter(negative="", help="Remove what is kept of untouched sensors.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Say what this machine can do, how to get the rest, and what is kept on disk."""
    from magicsim.cli.answers.doctor import examine

    print_result(fields_of(examine(clear_cache=clear_cache)), as_json=json)


@app.command
def schema(
    kind: Literal[
        "design", "scene", "rig", "object", "recipe", "profile", "suite", "sweep", "study", "item", "real",
    ] = "scene", *,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Print the JSON Schema of a kind of configuration file."""
    from magicsim.cli.answers.schema import schema_of

    print_object(schema_of(kind), on_one_line=json)
