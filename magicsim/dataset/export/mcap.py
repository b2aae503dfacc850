"""One episode as an MCAP file, which robot logs are kept in: Foxglove's message types, PNG images, one clock.

Images, masks and truth come at the camera's rate, what stands still once a second. Times are those of the episode, from
0. Foxglove's poses and transforms are in metres; `/tactile/truth` has the names and units of datasets.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import foxglove
import numpy as np
from foxglove.channels import CameraCalibrationChannel, CompressedImageChannel, FrameTransformsChannel
from foxglove.mcap import MCAPWriteOptions
from foxglove.messages import (
    CameraCalibration,
    CompressedImage,
    FrameTransform,
    FrameTransforms,
    Quaternion,
    Timestamp,
    Vector3,
)
from scipy.spatial.transform import Rotation

from magicsim import __version__
from magicsim.config.documents import without_nan
from magicsim.dataset.export.source import Source

Row = Mapping[str, Any]
IMAGE, MASK, TRUTH, CALIBRATION = "/tactile/image", "/tactile/contact_mask", "/tactile/truth", "/tactile/calibration"
TRANSFORMS = "/tf"
SENSOR, CAMERA, OBJECT = "sensor", "camera", "object"
"""Frames: of the contact face, of the camera (x right, y down, z ahead), of the object."""
STILL_S = 1.0
"""Time between two messages about what stands still [s]."""
M_PER_MM = 1e-3
NS_PER_S = 1_000_000_000
NUMBER, FLAG, TEXT = {"type": ["number", "null"]}, {"type": "boolean"}, {"type": "string"}
VECTOR = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
TRUTH_FIELDS: dict[str, dict[str, Any]] = {
    "time_s": NUMBER, "step": {"type": "integer"}, "is_reference": FLAG, "frame_class": TEXT, "gap_mm": NUMBER,
    "contact": FLAG, "depth_mm": NUMBER, "force_n": VECTOR, "torque_nmm": VECTOR, "contact_area_mm2": NUMBER,
    "flashlight": FLAG,
}  # fmt: skip
"""Columns of a dataset that `/tactile/truth` carries, as JSON; a gap is null without an object."""


def write_mcap_episode(
    target: Path, rows: Iterable[Row], *, size: tuple[int, int], about: Mapping[str, str] | None = None
) -> None:
    """Writes the rows of one episode, in order of time, to a new file; `size` is columns and rows of images [px]."""
    context = foxglove.Context()  # of its own, so that nothing else is recorded
    options = MCAPWriteOptions(compression_threads=0)
    schema = {"type": "object", "title": "magicsim.Truth", "properties": TRUTH_FIELDS}
    with foxglove.open_mcap(str(target), context=context, writer_options=options) as writer:
        writer.write_metadata("magicsim", {"version": __version__, **(about or {})})
        images, masks = (CompressedImageChannel(topic, context=context) for topic in (IMAGE, MASK))
        calibrations = CameraCalibrationChannel(CALIBRATION, context=context)
        transforms = FrameTransformsChannel(TRANSFORMS, context=context)
        truths = foxglove.Channel(TRUTH, schema=schema, message_encoding="json", context=context)
        due_s = 0.0
        for row in rows:
            at = round(row["time_s"] * NS_PER_S)
            stamp = Timestamp(at // NS_PER_S, at % NS_PER_S)
            moving = _object(row, stamp)
            if row["time_s"] >= due_s:
                due_s += STILL_S
                calibrations.log(_calibration(row, size, stamp), log_time=at)
                moving = [_transform(CAMERA, row["camera_position_mm"], row["camera_rotation"], stamp), *moving]
            if moving:
                transforms.log(FrameTransforms(transforms=moving), log_time=at)
            images.log(_png(row["image"], stamp), log_time=at)
            if row.get("contact_mask") is not None:
                masks.log(_png(row["contact_mask"], stamp), log_time=at)
            truth = without_nan({name: row[name] for name in TRUTH_FIELDS})
            truths.log(json.dumps(truth).encode(), log_time=at)


def _png(value: Mapping[str, Any], stamp: Timestamp) -> CompressedImage:
    return CompressedImage(timestamp=stamp, frame_id=CAMERA, data=value["bytes"], format="png")


def _calibration(row: Row, size: tuple[int, int], stamp: Timestamp) -> CameraCalibration:
    matrix = list(row["camera_matrix"])
    projection = np.concatenate([np.reshape(matrix, (3, 3)), np.zeros((3, 1))], 1)
    return CameraCalibration(
        timestamp=stamp, frame_id=CAMERA, width=size[0], height=size[1], distortion_model="plumb_bob",
        D=list(row["camera_distortion"]), K=matrix, R=np.eye(3).ravel().tolist(), P=projection.ravel().tolist(),
    )  # fmt: skip


def _object(row: Row, stamp: Timestamp) -> list[FrameTransform]:
    position = row["object_position_mm"]
    if position is None or not np.isfinite(position).all():
        return []
    return [_transform(OBJECT, position, row["object_rotation"], stamp)]


def _transform(name: str, position_mm: Any, rotation: Any, stamp: Timestamp) -> FrameTransform:  # noqa: ANN401 - numbers
    x, y, z = (M_PER_MM * float(each) for each in position_mm)
    turn = Rotation.from_matrix(np.reshape(rotation, (3, 3))).as_quat().tolist()
    return FrameTransform(
        timestamp=stamp,
        parent_frame_id=SENSOR,
        child_frame_id=name,
        translation=Vector3(x=x, y=y, z=z),
        rotation=Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3]),
    )


def write_mcap(source: Source, folder: Path) -> None:
    """Writes `<split>/episode-NNNNNNNN.mcap`."""
    window = source.recipe.rig.camera.window
    for split in source.splits:
        (folder / split).mkdir()
        for shard in source.shards(split):
            for number, table in zip(shard.episodes, source.episodes(shard), strict=True):
                write_mcap_episode(
                    folder / split / f"episode-{number:08d}.mcap",
                    table.to_pylist(),
                    size=(window.columns, window.rows),
                    about={"episode": str(number), "config_hash": source.manifest.config_hash},
                )
