"""Commands that take a design alone: `export`."""

from magicsim.cli.app import Json, Out, Seed, Settings, app, fields_of, print_result


@app.command
def export(design: str, *, out: Out, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Write a design's geometry: the clear part with its cavities, and the infill.

    The suffix of --out chooses the format: .3mf to print (mm, both parts in one file), .glb to look at (metres, as glTF
    asks) or .stl (mm, the infill in a second file).
    """
    from magicsim.config.models import load_preset
    from magicsim.geometry.design import ElastomerDesign
    from magicsim.geometry.files.export import export_design

    print_result(
        fields_of(export_design(load_preset(ElastomerDesign, "design", design, settings or []), out)),
        as_json=json,
    )
