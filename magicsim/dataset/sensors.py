"""The printed sensors of a dataset: drawn values, calibration and lattice of each."""

import io
import json
from collections.abc import Sequence
from dataclasses import asdict

import pyarrow as pa

from magicsim.camera.calibration import calibrate_camera
from magicsim.dataset.features import Column, array, schema_of_columns, value
from magicsim.dataset.recipes.draw import DrawnSensor
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.shard import ROWS_A_GROUP, write_rows
from magicsim.deform.lattice.structure import box_lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import lattice_planes, resolve_grid


def nominal_calibration(recipe: Recipe) -> bytes:
    """Calibration of the sensor without tolerances, as JSON."""
    return (json.dumps(asdict(calibrate_camera(recipe.design, recipe.rig)), indent=1) + "\n").encode()


def sensors_table(sensors: Sequence[DrawnSensor]) -> bytes:
    """A Parquet file with one row a sensor; a few sensors are in memory at a time.

    Raises:
        GeometryError: A drawn design cannot be built.
    """
    names = sorted(sensors[0].values)
    columns: list[Column] = [
        value("sensor", "int32", "number of the sensor"),
        value("design", "string", "its design as JSON"),
        value("rig", "string", "its rig as JSON"),
        value("calibration", "string", "its calibration as JSON"),
        array("lattice_nodes_mm", (None, 3), "rest positions of its lattice nodes [mm]", dtype="float64"),
        *(value(f"drawn.{name}", "float64", "drawn value") for name in names),
    ]
    schema = schema_of_columns(columns)

    def table(some: Sequence[DrawnSensor]) -> pa.Table:
        rows = [_row(sensor) for sensor in some]
        arrays = [pa.array([row[column.name] for row in rows], column.arrow) for column in columns]
        return pa.Table.from_arrays(arrays, schema=schema)

    sink = io.BytesIO()
    begins = range(0, len(sensors), ROWS_A_GROUP)
    write_rows(sink, (table(sensors[begin : begin + ROWS_A_GROUP]) for begin in begins), schema)
    return sink.getvalue()


def _nodes_mm(design: ElastomerDesign) -> list[list[float]]:
    """Nodes of `build_lattice`, without the stiffness between them [mm]."""
    x, y, z = lattice_planes(design, resolve_grid(design))
    body = design.materials.body
    return box_lattice(  # type: ignore[no-any-return]
        (x, y, z), shear_modulus_mpa=body.shear_modulus_mpa, lame_mpa=body.lame_mpa
    ).nodes_mm.tolist()


def _row(sensor: DrawnSensor) -> dict[str, object]:
    return {
        "sensor": sensor.index,
        "design": sensor.design.model_dump_json(),
        "rig": sensor.rig.model_dump_json(),
        "calibration": json.dumps(asdict(calibrate_camera(sensor.design, sensor.rig))),
        "lattice_nodes_mm": _nodes_mm(sensor.design),
    } | {f"drawn.{name}": number for name, number in sensor.values.items()}
