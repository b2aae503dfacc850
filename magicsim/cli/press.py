"""Commands of one design: `press` and `press durometer`, which solve contacts, and `export`."""

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, app, print_result
from magicsim.errors import ConfigError

press_app = App(name="press")
app.command(press_app)


@press_app.default
def press(
    design: str, *, object: Annotated[str, Parameter(name="--object", help="KIND:key=value,...")],
    depth_mm: Annotated[float | None, Parameter(help="From first contact; with --limits the deepest tried.")] = None,
    shear_mm: Annotated[str, Parameter(allow_leading_hyphen=True, help="X,Y after the press.")] = "0,0",
    twist_deg: float = 0.0, friction: float = 0.0,
    speed_mm_s: Annotated[float | None, Parameter(help="Speed, for a path that takes time.")] = None,
    hold_s: Annotated[float, Parameter(help="Time at the end of such a path.")] = 0.0,
    infill_yield_mpa: Annotated[float | None, Parameter(help="Shear stress at which the infill flows.")] = None,
    wall_buckling_strain: Annotated[float | None, Parameter(help="Squeeze from which walls carry no more.")] = None,
    wall_tear_elongation: Annotated[float | None, Parameter(help="Elongation at which walls tear; 2.2: 220 %.")] = None,
    release: Annotated[bool, Parameter(negative="", help="Lift off at the end: the dent that is left.")] = False,
    curve: Annotated[Path | None, Parameter(help="FILE.csv or .png: force against depth, up to --depth-mm.")] = None,
    points: Annotated[int, Parameter(help="Depths of the curve, evenly from 0.")] = 21,
    limits: Annotated[bool, Parameter(negative="", help="Where infill yields, skin tears, walls tear.")] = False,
    max_iterations: Annotated[int, Parameter(help="Bound on time: iterations at one place of the path.")] = 2000,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Solve one contact: press, then shear, then twist; quasi-static unless a speed is given.

    With --curve the press is solved once, depth after depth, and force against depth goes to a table or a picture.
    With --limits it goes on until every strength of the design's [limits] is passed, and says at which depth and force.
    """
    from magicsim.config.models import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.objects.kinds import parse_object

    block = load_preset(ElastomerDesign, "design", design, settings or [])
    thing, shear = parse_object(object), _pair("shear_mm", shear_mm)
    if curve is not None or limits:
        others = {"shear_mm": shear != (0.0, 0.0), "twist_deg": twist_deg != 0, "hold_s": hold_s != 0}
        others |= {"speed_mm_s": speed_mm_s is not None, "curve": limits and curve is not None, "release": release}
        why = "limits: they are of" if limits else "curve: a curve is"
        for name, is_given in others.items():
            if is_given:
                raise ConfigError(f"{name} is not allowed with {why} a straight press without time")
    laws: dict[str, Any] = {
        "friction": friction, "infill_yield_mpa": infill_yield_mpa, "wall_buckling_strain": wall_buckling_strain,
        "wall_tear_elongation": wall_tear_elongation,
    }  # fmt: skip
    from magicsim.cli.progress import show_progress

    if limits:
        from magicsim.deform.indentation.bearing import press_limits

        with show_progress(f"{design}: limits") as progress:
            found = press_limits(block, thing, depth_mm=depth_mm, **laws, progress=progress)
        print_result(found.as_dict() | {"design_limits": block.limits.model_dump(mode="json")}, as_json=json)
        return
    if depth_mm is None:
        raise ConfigError("--depth-mm is missing: only with --limits it may be left out")
    if curve is not None:
        from magicsim.config.ranges import check_number
        from magicsim.deform.indentation.press import MAX_POINTS, check_depth, press_curve
        from magicsim.report.drawing import check_curve_file, write_curve

        check_curve_file(curve)
        check_number("points", points, 2, MAX_POINTS, whole=True)
        check_depth(depth_mm, block)
        if depth_mm == 0:
            raise ConfigError("depth_mm = 0 is not allowed with curve: must be above 0")
        depths = [depth_mm * number / (points - 1) for number in range(points)]
        title = f"{object} pressed into {design}" + (f", friction {friction:g}" if friction else "")
        with show_progress(title) as progress:
            solved = press_curve(block, thing, depths, **laws, max_iterations=max_iterations, progress=progress)
        write_curve(solved, curve, title=title)
        print_result(solved.result.as_dict() | {"curve": str(curve)}, as_json=json)
        return
    from magicsim.deform.indentation.press import press as solve

    with show_progress(f"{design}: press") as progress:
        result = solve(
            block, thing, depth_mm=depth_mm, shear_mm=shear, twist_deg=twist_deg, speed_mm_s=speed_mm_s, hold_s=hold_s,
            **laws, release=release, max_iterations=max_iterations, progress=progress,
        )  # fmt: skip
    print_result(result.as_dict(), as_json=json)


@press_app.command
def durometer(
    design: str, *, place: Literal["cell", "wall"] = "cell",
    base: Annotated[Literal["table", "bonded"], Parameter(help="What the sample does below.")] = "table",
    friction: Annotated[float, Parameter(help="Of the tool; that of the table is mounting.friction.")] = 1.0,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Press a virtual Shore A durometer into a block, on the centre of a cell or where walls cross.

    The block lies on a table, with `mounting.friction`, whatever its own mounting is, or is bonded to it.
    """
    from magicsim.config.models import load_preset
    from magicsim.geometry.design import ElastomerDesign

    block = load_preset(ElastomerDesign, "design", design, settings or [])
    from magicsim.cli.progress import show_progress
    from magicsim.deform.deformation import figures_last
    from magicsim.deform.indentation.durometer import durometer as test

    with show_progress(f"{design}: cone") as progress:
        mounting = block.mounting.model_copy(update={"base": base})
        result = test(block, place=place, friction=friction, mounting=mounting, progress=progress)
    print_result(figures_last(result), as_json=json)


def _pair(name: str, text: str) -> tuple[float, float]:
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        raise ConfigError(f"{name} = '{text}' is not allowed: must be two numbers X,Y") from None
    return x, y


@app.command
def export(design: str, *, out: Out, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Write a design's geometry: the clear part with its cavities, and the infill.

    The suffix of --out chooses the format: .3mf to print (mm, both parts in one file), .glb to look at (metres, as glTF
    asks) or .stl (mm, the infill in a second file).
    """
    from magicsim.config.models import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.files.export import export_design

    block = load_preset(ElastomerDesign, "design", design, settings or [])
    print_result(export_design(block, out), as_json=json)
