"""Commands about the program itself: `doctor`, `schema`."""

from typing import Annotated, Literal

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, app, fields_of, print_object, print_result
from magicsim.errors import ConfigError


@app.command(show=False)
def bench(*words: Annotated[str, Parameter(allow_leading_hyphen=True)]) -> None:
    """Say where the benchmarks are."""
    kind = next((word for word in words if word in {"stress", "cost", "render"}), "deform")
    msg = f"bench is a script of the repository now: python benchmarks/{kind}.py"
    raise ConfigError(msg)


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
