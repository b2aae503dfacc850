"""The printed sensors of a dataset: drawn values, calibration and lattice of each."""

import json
from dataclasses import asdict

import pyarrow as pa

from magicsim.dataset.draw import DrawnSensor
from magicsim.dataset.features import Column, array, schema_of_columns, value
from magicsim.dataset.recipe import Recipe
from magicsim.dataset.shard import rows_as_bytes
from magicsim.deform.lattice import build_lattice
from magicsim.scenes.calibration import calibrate


def nominal_calibration(recipe: Recipe) -> bytes:
    """Calibration of the sensor without tolerances, as JSON."""
    return (json.dumps(asdict(calibrate(recipe.design, recipe.rig)), indent=1) + "\n").encode()


def sensors_table(sensors: list[DrawnSensor]) -> bytes:
    """A Parquet file with one row a sensor.

    Raises:
        GeometryError: A drawn design cannot be built.
    """
    names = sorted({name for sensor in sensors for name in sensor.values})
    columns: list[Column] = [
        value("sensor", "int32", "number of the sensor"),
        value("design", "string", "its design as JSON"),
        value("rig", "string", "its rig as JSON"),
        value("calibration", "string", "its calibration as JSON"),
        array("lattice_nodes_mm", (None, 3), "rest positions of its lattice nodes [mm]", dtype="float64"),
        *(value(f"drawn.{name}", "float64", "drawn value") for name in names),
    ]
    rows = [_row(sensor) for sensor in sensors]
    table = {column.name: pa.array([row[column.name] for row in rows], column.arrow) for column in columns}
    return rows_as_bytes(pa.Table.from_arrays(list(table.values()), schema=schema_of_columns(columns)))


def _row(sensor: DrawnSensor) -> dict[str, object]:
    return {
        "sensor": sensor.index,
        "design": sensor.design.model_dump_json(),
        "rig": sensor.rig.model_dump_json(),
        "calibration": json.dumps(asdict(calibrate(sensor.design, sensor.rig))),
        "lattice_nodes_mm": build_lattice(sensor.design).nodes_mm.tolist(),
    } | {f"drawn.{name}": number for name, number in sensor.values.items()}
