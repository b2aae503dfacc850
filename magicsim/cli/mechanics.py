"""Commands that solve contacts: `press`, `durometer`."""

from typing import Annotated, Literal

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, app, fields_of, print_result
from magicsim.errors import ConfigError


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
    from magicsim.config.models import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.objects.kinds import parse_object

    block = load_preset(ElastomerDesign, "design", design, settings or [])
    thing, shear = parse_object(object), _pair("shear_mm", shear_mm)
    from magicsim.cli.progress import show_progress
    from magicsim.deform.indentation.press import press as solve

    with show_progress(f"{design}: press") as progress:
        result = solve(
            block, thing, depth_mm=depth_mm, shear_mm=shear, twist_deg=twist_deg, friction=friction,
            speed_mm_s=speed_mm_s, hold_s=hold_s, progress=progress,
        )  # fmt: skip
    print_result(result.as_dict(), as_json=json)


@app.command
def durometer(
    design: str, *, place: Literal["cell", "wall"] = "cell",
    base: Annotated[Literal["table", "bonded"], Parameter(help="What the sample does below.")] = "table",
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Press a virtual Shore A durometer into a block, on the centre of a cell or where walls cross.

    The block lies on a table, with `mounting.friction`, whatever its own mounting is, or is bonded to it.
    """
    from magicsim.config.models import load_preset
    from magicsim.geometry.design import ElastomerDesign

    del seed  # nothing here is random; the option exists on every command
    block = load_preset(ElastomerDesign, "design", design, settings or [])
    from magicsim.cli.progress import show_progress
    from magicsim.deform.indentation.durometer import durometer as test

    with show_progress(f"{design}: cone") as progress:
        mounting = block.mounting.model_copy(update={"base": base})
        result = test(block, place=place, mounting=mounting, progress=progress)
    print_result(fields_of(result), as_json=json)


def _pair(name: str, text: str) -> tuple[float, float]:
    parts = text.split(",")
    try:
        x, y = (float(part) for part in parts)
    except ValueError:
        msg = f"{name} = '{text}' is not allowed: must be two numbers X,Y"
        raise ConfigError(msg) from None
    return x, y
