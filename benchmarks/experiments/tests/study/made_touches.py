"""Touches that cost nothing: a spot where the object is, as bright as it is near or deep."""

import math

import cv2
import numpy as np
import pyarrow as pa

from magicsim.dataset.rows import SampleTask
from magicsim.dataset.shard import rows_as_bytes, schema_of_columns
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.workers.attempt import Work

EMPTY = {"string": "", "bool": False, "int32": 0, "int64": 0}


def made_rows(task: SampleTask) -> bytes:
    """Rows of an episode; its frames are those of the recipe's path."""
    scene = task.episode.scene
    states = [*[UNTOUCHED] * scene.references, *timeline(scene)]
    random = np.random.default_rng(scene.seed)
    rows = []
    for step, state in enumerate(states):
        row = {column.name: _empty(column, scene.rig.camera) for column in task.columns}
        depth = max(0.0, -state.gap_mm) if state.gap_mm is not None else 0.0
        row |= {
            "image": _png(_image(scene, state, depth, random)), "episode": task.episode.index, "step": step,
            "sensor": task.episode.sensor, "is_reference": step < scene.references, "contact": depth > 0,
            "gap_mm": math.nan if state.gap_mm is None else state.gap_mm, "depth_mm": depth,
            "force_n": [0.2 * state.x_mm, 0.1 * depth, 2 * depth],
        }  # fmt: skip
        if state.gap_mm is not None:
            angle = math.radians(scene.object.yaw_deg)
            cosine, sine = math.cos(angle), math.sin(angle)
            row |= {
                "object_kind": scene.object.kind, "object_config": scene.object.model_dump_json(),
                "object_position_mm": [state.x_mm, state.y_mm, 0.0],
                "object_rotation": [cosine, -sine, 0, sine, cosine, 0, 0, 0, 1.0],
            }  # fmt: skip
        if "contact_mask" in row:
            row["contact_mask"] = _png(np.uint8(255) * (_spot(scene, state) > 0.5) * np.uint8(depth > 0))
        rows.append(row)
    arrays = [pa.array([row[column.name] for row in rows], column.arrow) for column in task.columns]
    return rows_as_bytes(pa.Table.from_arrays(arrays, schema=schema_of_columns(task.columns)))


def _variant() -> str:
    return "none"


MADE = Work(function=made_rows, prepare=None, variant=_variant)


def _spot(scene, state) -> np.ndarray:
    camera, (width, length) = scene.rig.camera, scene.design.footprint_mm
    x = (np.arange(camera.columns) + 0.5) / camera.columns * width - width / 2
    y = length / 2 - (np.arange(camera.rows) + 0.5) / camera.rows * length
    return np.exp(-((x[None] - state.x_mm) ** 2 + (y[:, None] - state.y_mm) ** 2) / 8)


def _image(scene, state, depth: float, random: np.random.Generator) -> np.ndarray:
    camera = scene.rig.camera
    image = np.full((camera.rows, camera.columns, 3), 60.0)
    if state.gap_mm is not None:
        strength = 40 + 60 * depth if depth > 0 else 40 * math.exp(-state.gap_mm / 6)
        size = getattr(scene.object, "width_mm", None) or getattr(scene.object, "radius_mm", None) or 1.0
        image += (strength * _spot(scene, state) ** (1 / size))[:, :, None] * np.array([1.0, 0.7, 0.4])
    return np.clip(np.rint(image + random.normal(0, 1, image.shape)), 0, 255).astype(np.uint8)


def _png(pixels: np.ndarray) -> dict:
    return {"bytes": cv2.imencode(".png", pixels)[1].tobytes(), "path": None}


def _empty(column, camera) -> object:
    kind = column.feature["_type"]
    if kind == "Image":
        return _png(np.zeros((camera.rows, camera.columns), np.uint8))
    if kind == "Sequence":
        return [math.nan] * column.feature["length"]
    return EMPTY.get(column.feature["dtype"], 0.0) if kind != "Array2D" else []
