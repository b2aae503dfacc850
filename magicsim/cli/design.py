"""Commands that take a design alone: `export`."""

from magicsim.cli.app import Json, Out, Seed, Settings, app, fields_of, print_result


@app.command
def export(design: str, *, out: Out, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Write a design's printable geometry as STL: the clear part with its cavities, and the infill beside it."""
    from magicsim.config import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.export import export_design

    del seed  # nothing here is random; the option exists on every command
    print_result(
        fields_of(export_design(load_preset(ElastomerDesign, "design", design, settings or []), out)),
        as_json=json,
    )
