"""Which columns the rows of a recipe have, and those of recorded frames."""

from dataclasses import replace
from typing import get_args

from magicsim.dataset.card import as_metadata
from magicsim.dataset.recipes.draw import drawn_names
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.shard import Column, array, image, value, vector
from magicsim.scenes.scene import TaxelSettings
from magicsim.scenes.timeline import ImageOrigin, LightOrigin, TierError

DRAWN = "drawn."
"""How the names of columns with drawn values begin."""


def columns_of(recipe: Recipe) -> list[Column]:
    """All columns, in order."""
    camera, strips = recipe.rig.camera, len(recipe.rig.strips)
    columns = [
        *_of_moment(as_metadata(recipe)),
        *_large(recipe, (camera.rows, camera.columns)),
        *_of_object(),
        # Lists of no numbers are written, but cannot be read.
        *(
            [vector("led_radiance", 3 * strips, "radiance of each LED strip, RGB, in the rig's order")]
            if strips
            else []
        ),
        *_of_surroundings(),
        *(
            [value("passing_x_mm", "float64", "where something passes along x; NaN while away [mm]")]
            if recipe.may_pass
            else []
        ),
        *_of_camera(),
        *(
            value(
                f"{what}_way", "string", f"how the renderer made the {what}: {', '.join(get_args(ways)[1:])}; no label"
            )
            for what, ways in (("light", LightOrigin), ("image", ImageOrigin))
        ),
        value("beyond_limits", "bool", "whether force or depth is above what the design's `limits` say"),
        value("in_view", "bool", "whether the picture covers where the object touches or stands; true without one"),
        *(
            value(
                f"tier_{name}",
                "float64",
                f"{what} of an emulated frame off a true one; NaN unless checked [grey levels]",
            )
            for name, what in zip(TierError._fields, ("mean distance", "95 %", "99 %"), strict=True)
            if recipe.render.tier == "fast"
        ),
        value("iterations", "int32", "Newton iterations of the frame's deformation"),
        value("min_jacobian", "float64", "smallest Jacobian of the deformation, above 0"),
        value("max_penetration_mm", "float64", "deepest contact point inside the object [mm]"),
        value("force_balance", "float64", "relative difference of contact force and reaction"),
        value("seed", "int64", "seed of the episode"),
        value("config_hash", "string", "SHA-256 of the recipe"),
        value("version", "string", "programs that made the row"),
        value("variant", "string", "Mitsuba variant that rendered"),
    ]
    return columns + [
        value(f"{DRAWN}{name}", "float64", "drawn value; NaN where it does not apply") for name in drawn_names(recipe)
    ]


def recorded_columns() -> list[Column]:
    """Columns that frames of a real sensor may have, in order; names, types and units are those of simulated ones."""
    return [
        *_of_moment(None),
        *_of_object(),
        *_of_surroundings(),
        *_of_camera(),
        value("config_hash", "string", "SHA-256 of the description and of what it names"),
        value("version", "string", "programs that made the row"),
    ]


def _of_moment(force_metadata: dict[str, str] | None) -> list[Column]:
    """Columns of one moment: the image, its time, and how the object touches."""
    force = vector("force_n", 3, "force of the object on the sensor [N]")
    return [
        image("image", "what the camera sees: RGB PNG, row 0 at +y, column 0 at -x"),
        value("episode", "int32", "number of the episode"),
        value("step", "int32", "place in the episode, reference frames first"),
        value("time_s", "float64", "time from the episode's first frame [s]"),
        value("is_reference", "bool", "whether the sensor is untouched as a reference before the episode"),
        value("sensor", "int32", "number of the printed sensor, a row of `sensors.parquet`"),
        value("path_kind", "string", "what happens in the episode"),
        value(
            "frame_class",
            "string",
            "Clear, Near, Light touch (below 0.3 mm), Contact or Light; empty between them and for references",
        ),
        value(
            "gap_mm", "float64", "gap of the object to the undeformed face, negative when pressed; NaN without one [mm]"
        ),
        value("contact", "bool", "whether a contact force acts"),
        value("depth_mm", "float64", "indentation depth [mm]"),
        replace(force, metadata=force_metadata),
        vector("torque_nmm", 3, "its torque about the origin [N mm]"),
        value("contact_area_mm2", "float64", "area that touches [mm2]"),
    ]


def _of_object() -> list[Column]:
    return [
        value("object_kind", "string", "kind of the episode's object, also in reference rows; empty without one"),
        value("object_config", "string", "the object's shape, orientation and colour as JSON, empty without one"),
        vector("object_color", 3, "its diffuse reflectance, linear RGB; NaN without one"),
        value("object_specular", "float64", "share of the light that it mirrors"),
        value("object_roughness", "float64", "root mean square slope of the facets that mirror"),
        vector("object_position_mm", 3, "origin of its frame in the sensor's frame; NaN without one [mm]"),
        vector("object_rotation", 9, "rotation matrix from its frame to the sensor's, row by row"),
        value("twist_deg", "float64", "its turn about z on the path [degrees]"),
        value("friction", "float64", "Coulomb's coefficient between skin and object"),
    ]


def _of_surroundings() -> list[Column]:
    return [
        value("room", "string", "room that the sensor stands in: a preset, `dark`, a file, or empty for even light"),
        vector("room_radiance", 3, "its mean radiance, RGB, in the units of the strips'"),
        value("flashlight", "bool", "whether the outside light is on"),
        vector("flashlight_radiance", 3, "its radiance, RGB"),
        value("flashlight_x_mm", "float64", "its centre along x [mm]"),
    ]


def _of_camera() -> list[Column]:
    return [
        vector("camera_matrix", 9, "intrinsics in air, row by row [px]; pixel centres are whole"),
        vector("camera_distortion", 5, "OpenCV's k1, k2, p1, p2, k3"),
        vector("camera_position_mm", 3, "pinhole in the sensor's frame [mm]"),
        vector("camera_rotation", 9, "rotation from the camera's frame (x right, y down, z ahead) to the sensor's"),
    ]


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
    if recipe.design.markers is not None:
        large += [
            array(
                "markers_mm", (None, 3), "centre of each marker, displaced, in the sensor's frame [mm]", dtype="float64"
            ),
            array("markers_px", (None, 2), "column and row at which the camera sees each marker [px]", dtype="float64"),
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
