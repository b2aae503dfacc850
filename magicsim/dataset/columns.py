"""Which columns the rows of a recipe have, and those of recorded frames."""

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import get_args

from magicsim.dataset.card import force_error
from magicsim.dataset.recipes.draw import drawn_names
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.shard import Column, array, image, value, vector
from magicsim.scenes.scene import TaxelSettings
from magicsim.scenes.timeline import ImageOrigin, LightOrigin

DRAWN = "drawn."
"""How the names of columns with drawn values begin."""


def _column(name: str, type: str, meaning: str) -> Column:
    if type == "image":
        return image(name, meaning)
    kind, _, length = type.partition(" ")
    return vector(name, int(length), meaning) if kind == "vector" else value(name, type, meaning)


PARTS: dict[str, list[Column]] = {}
"""Columns of `columns.csv` by the part of a row that they belong to, in order."""
with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as _file:
    for _cells in csv.DictReader(_file):
        PARTS.setdefault(_cells.pop("part"), []).append(_column(**_cells))


def columns_of(recipe: Recipe) -> list[Column]:
    """All columns, in order."""
    camera, strips = recipe.rig.camera, len(recipe.rig.strips)
    led = vector("led_radiance", 3 * strips, "radiance of each LED strip, RGB, in the rig's order")
    error = {"relative_error": json.dumps(force_error(recipe))}  # null is one that is not known
    return [
        *(replace(each, metadata=error) if each.name == "force_n" else each for each in PARTS["moment"]),
        *_large(recipe, (camera.window.rows, camera.window.columns)),
        *PARTS["object"],
        *([led] if strips else []),  # lists of no numbers are written, but cannot be read
        *PARTS["surroundings"],
        *(PARTS["passing"] if recipe.may_pass else []),
        *PARTS["camera"],
        *(
            value(
                f"{what}_way", "string", f"how the renderer made the {what}: {', '.join(get_args(ways)[1:])}; no label"
            )
            for what, ways in (("light", LightOrigin), ("image", ImageOrigin))
        ),
        *PARTS["seen"],
        *(PARTS["checked"] if recipe.render.tier == "fast" else []),
        *(PARTS["flow"] if recipe.contact.infill_yield_mpa is not None else []),
        *PARTS["solved"],
        *(
            value(f"{DRAWN}{name}", "float64", "drawn value; NaN where it does not apply")
            for name in drawn_names(recipe)
        ),
    ]


def recorded_columns() -> list[Column]:
    """Columns that frames of a real sensor may have, in order; names, types and units are those of simulated ones."""
    return [each for part in ("moment", "object", "surroundings", "camera", "source") for each in PARTS[part]]


def _large(recipe: Recipe, size: tuple[int, int]) -> list[Column]:
    labels, large = recipe.labels, []
    if labels.contact_mask:
        large.append(image("contact_mask", "255 where a pixel's ray meets the contact, PNG"))
    if labels.depth_map:
        large.append(array("depth_map_mm", size, "how far the contact face is pressed in at each pixel [mm]"))
    if labels.displacements:
        large.append(
            array("displacements_mm", (None, 3), "of each lattice node, in the order of `sensors.parquet` [mm]")
        )
    if labels.taxels is not None:
        large += _touch(labels.taxels, recipe)
    if (markers := recipe.design.markers) is not None:
        count, place = len(markers.centres_mm(recipe.design.footprint_mm)), "centre of each marker, displaced,"
        large += [
            array("markers_mm", (count, 3), f"{place} in the sensor's frame [mm]", dtype="float64"),
            array(
                "markers_px", (count, 2), "column and row at which the camera sees each marker [px]", dtype="float64"
            ),
        ]
    return large


def _touch(taxels: TaxelSettings, recipe: Recipe) -> list[Column]:
    """Columns of the taxels, row by row, row 0 at +y and column 0 at -x."""
    size, count = (taxels.rows, taxels.columns), taxels.rows * taxels.columns
    grid = f"{taxels.rows} x {taxels.columns} taxels over the face, row by row, row 0 at +y"
    load = ("taxel_force_n", f"force of the object on each of {grid} [N]")
    if taxels.unit == "MPa":
        load = ("taxel_traction_mpa", f"force of the object per undeformed area on each of {grid} [MPa]")
    columns = [
        array(load[0], (count, 3), load[1], dtype="float64"),
        array("taxel_torque_nmm", (count, 3), "torque of those forces about the origin [N mm]", dtype="float64"),
    ]
    images = {}
    if taxels.skin:
        images["skin_stretch"] = "principal stretch of the skin below each taxel, 1 at rest"
        images["skin_von_mises_mpa"] = "von Mises stress of the skin below each taxel [MPa]"
    if taxels.has_infill(recipe.design):
        images["infill_shear"] = "shear of the infill below each taxel, of all layers of cells, 0 at rest"
    for name, meaning in images.items():
        columns.append(array(name, size, f"largest {meaning}"))
        columns.append(value(f"max_{name}", "float64", f"largest of `{name}`"))
    return columns
