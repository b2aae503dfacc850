"""Rows of a dataset: the frames of one simulated episode, which is the unit of work, and the printed sensors.

Where a press ends at a force, its depth is found by pressing, and stands in the place of the deepest one.
"""

import io
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import pyarrow as pa

from magicsim.camera.projection import CameraCalibration, calibrate_camera
from magicsim.dataset.columns import DRAWN
from magicsim.dataset.recipes.draw import DrawnEpisode, DrawnSensor
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.shard import (
    ROWS_A_GROUP,
    Column,
    array,
    png_cell,
    rows_as_bytes,
    schema_of_columns,
    table_of_rows,
    value,
    write_rows,
)
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.force import DIGITS, press_to_force
from magicsim.deform.lattice.structure import box_lattice
from magicsim.errors import ConfigError
from magicsim.geometry.grid import lattice_planes, resolve_grid
from magicsim.geometry.indenter import Indenter
from magicsim.light.records.untouched import shared_states
from magicsim.scenes.scene import Keyframe, SceneConfig
from magicsim.scenes.timeline import TierError, placed_in, timeline
from magicsim.simulation.emulation import CHECKED_SHARE
from magicsim.simulation.episode import SimulatedFrame, truth_row
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import stream_frames
from magicsim.simulation.touch_truth import touch_columns


def at_force(episode: DrawnEpisode) -> tuple[DrawnEpisode, Deformation | None]:
    """The episode with keyframes that press as deep as its force does, and the equilibrium at that depth.

    Itself where it has no force; no equilibrium where none is known.

    Raises:
        ConfigError: The object does not reach the force before the depth limit.
        MagicsimError: The press has no valid answer.
    """
    scene, force = episode.scene, episode.force_n
    deepest = max((-keyframe.gap_mm for keyframe in scene.keyframes if keyframe.gap_mm is not None), default=0.0)
    if force is None or scene.object is None or deepest <= 0:
        return episode, None
    found = press_to_force(
        scene.design, lambda depth: _touching(_pressed(scene, depth, deepest)), force, deepest_mm=deepest,
        friction=scene.contact.friction, quality=scene.contact.quality,
        failure=scene.contact.failure, max_iterations=scene.contact.max_iterations,
    )  # fmt: skip
    if episode.must_reach and not found.is_met:
        raise ConfigError(
            f"force_n = {force:.3g} is not reached: '{scene.object.kind}' presses with {found.force_n:.3g} N at the "
            f"depth limit of {found.depth_mm:.3g} mm; lower paths.force_n, or set paths.depth_mm beside it"
        )
    return replace(episode, scene=_pressed(scene, found.depth_mm, deepest)), found.state


def _pressed(scene: SceneConfig, depth_mm: float, deepest_mm: float) -> SceneConfig:
    """The scene pressed to a depth in place of its deepest one [mm]."""

    def scaled(keyframe: Keyframe) -> Keyframe:
        if keyframe.gap_mm is None or keyframe.gap_mm >= 0:
            return keyframe
        return keyframe.model_copy(update={"gap_mm": round(keyframe.gap_mm * depth_mm / deepest_mm, DIGITS)})

    return scene.model_copy(update={"keyframes": tuple(map(scaled, scene.keyframes))})


def _touching(scene: SceneConfig) -> Sequence[Indenter]:
    """The object where it is first as deep as ever, and then in all states that can touch, in order."""
    states = [state for state in timeline(scene) if state.can_touch]
    first = min(states, key=lambda state: state.gap_mm or 0.0)
    placed = (placed_in(state, scene.object, scene.design) for state in (first, *states))
    return [each for each in placed if each is not None]


DEPTH_STEP_MM = 2.0**-12
"""Depth maps are rounded to this step [mm], far below their error: what is rounded compresses."""
NONE = (None,) * len(TierError._fields)
CAMERA_ROTATION = (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
"""Camera frame (x right, y down, z ahead) to the sensor's: it looks along -z with x to the right."""


def episode_table(
    frames: list[SimulatedFrame],
    scene: SceneConfig,
    calibration: CameraCalibration,
    columns: list[Column],
    constants: dict[str, Any],
) -> pa.Table:
    """One row a frame, references first; constants are columns of one value."""
    rows = [row | constants for row in frame_rows(frames, scene, calibration)]
    for column in columns:
        if rows and column.name not in rows[0] and not column.name.startswith(DRAWN):
            raise ValueError(f"column '{column.name}' is declared in `columns_of`, and nothing fills it")
    return table_of_rows(rows, columns)


def frame_rows(
    frames: Iterable[SimulatedFrame], scene: SceneConfig, calibration: CameraCalibration
) -> Iterator[dict[str, Any]]:
    """The columns of each frame that do not come from a recipe."""
    shared = _of_scene(scene, calibration)
    return (_row(frame, scene) | shared for frame in frames)


def _of_scene(scene: SceneConfig, calibration: CameraCalibration) -> dict[str, Any]:
    rig, indenter = scene.rig, scene.object
    return {
        "object_kind": indenter.kind if indenter is not None else None,
        "object_config": json.dumps(indenter.model_dump(mode="json"), sort_keys=True) if indenter is not None else None,
        "object_color": list(indenter.color) if indenter is not None else None,
        "object_specular": indenter.specular if indenter is not None else None,
        "object_roughness": indenter.roughness if indenter is not None else None,
        "friction": scene.contact.friction,
        "led_radiance": [each for strip in rig.strips for each in strip.radiance],
        "room": rig.room,
        "room_radiance": list(rig.room_light),
        "flashlight_radiance": list(rig.flashlight.radiance),
        "camera_matrix": [each for row in calibration.camera_matrix for each in row],
        "camera_distortion": list(calibration.distortion),
        "camera_position_mm": [0.0, 0.0, calibration.pinhole_z_mm],
        "camera_rotation": list(CAMERA_ROTATION),
        "seed": scene.seed,
    }


def _row(frame: SimulatedFrame, scene: SceneConfig) -> dict[str, Any]:
    state = frame.truth.state
    placed = placed_in(state, scene.object, scene.design)
    pose = placed.pose if placed is not None else None
    error = frame.origin.error
    depth, mask = frame.labels.depth_map_mm, frame.labels.contact_mask
    touch, taxels = frame.labels.touch, scene.output.taxels
    touched = touch_columns(touch, taxels) if touch is not None and taxels is not None else {}
    return (
        touched
        | truth_row(frame)
        | {
            "image": png_cell(frame.image),
            "contact_mask": png_cell(mask.astype(np.uint8) * 255) if mask is not None else None,
            "depth_map_mm": np.rint(depth / DEPTH_STEP_MM) * DEPTH_STEP_MM + 0.0 if depth is not None else None,
            "displacements_mm": frame.labels.displacements_mm,
            "markers_mm": frame.labels.markers_mm,
            "markers_px": frame.labels.markers_px,
            "object_position_mm": pose.position_mm.tolist() if pose is not None else None,
            "object_rotation": pose.rotation.ravel().tolist() if pose is not None else None,
            "flashlight_x_mm": scene.rig.flashlight.x_mm + state.light_x_mm,
            "passing_x_mm": state.passing_mm,
        }
        | ({f"tier_{name}": value for name, value in zip(TierError._fields, error or NONE, strict=True)})
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTask:
    """One episode and how its rows are written."""

    episode: DrawnEpisode
    columns: list[Column]
    constants: dict[str, Any]
    """Columns that are the same in the whole dataset."""


def simulate_sample(task: SampleTask) -> bytes:
    """Simulates one episode: a Parquet file with one row a frame; trying again would not help against an error."""
    episode, known = at_force(task.episode)
    scene = episode.scene
    sensor = Sensor.for_scene(scene, untouched=shared_states())
    sensor.known = known
    sensor.emulation.checked_share = CHECKED_SHARE
    frames = list(stream_frames(sensor, plan_scene(scene)))
    constants = task.constants | {f"{DRAWN}{name}": number for name, number in episode.values.items()}
    constants |= {"episode": episode.index, "sensor": episode.sensor, "path_kind": episode.path_kind}
    calibration = calibrate_camera(scene.design, scene.rig)
    return rows_as_bytes(episode_table(frames, scene, calibration, task.columns, constants))


def nominal_calibration(recipe: Recipe) -> bytes:
    """Calibration of the sensor without tolerances, as JSON."""
    return (json.dumps(asdict(calibrate_camera(recipe.design, recipe.rig)), indent=1) + "\n").encode()


def sensors_table(sensors: Sequence[DrawnSensor]) -> bytes:
    """A Parquet file with one row a sensor; a few sensors are in memory at a time."""
    names = sorted({name for sensor in sensors for name in sensor.values})
    columns: list[Column] = [
        value("sensor", "int32", "number of the sensor"),
        value("design", "string", "its design as JSON"),
        value("rig", "string", "its rig as JSON"),
        value("calibration", "string", "its calibration as JSON"),
        array("lattice_nodes_mm", (None, 3), "rest positions of its lattice nodes [mm]", dtype="float64"),
        *(value(f"drawn.{name}", "float64", "drawn value, NaN where nothing is drawn") for name in names),
    ]
    sink, begins = io.BytesIO(), range(0, len(sensors), ROWS_A_GROUP)
    rows = ([_sensor_row(each) for each in sensors[begin : begin + ROWS_A_GROUP]] for begin in begins)
    write_rows(sink, (table_of_rows(each, columns) for each in rows), schema_of_columns(columns))
    return sink.getvalue()


def _sensor_row(sensor: DrawnSensor) -> dict[str, object]:
    body, planes = sensor.design.materials.body, lattice_planes(sensor.design, resolve_grid(sensor.design))
    lattice = box_lattice(planes, shear_modulus_mpa=body.shear_modulus_mpa, lame_mpa=body.lame_mpa)
    return {
        "sensor": sensor.index,
        "design": sensor.design.model_dump_json(),
        "rig": sensor.rig.model_dump_json(),
        "calibration": json.dumps(asdict(calibrate_camera(sensor.design, sensor.rig))),
        "lattice_nodes_mm": sensor.design.lifted(lattice.nodes_mm),
    } | {f"drawn.{name}": number for name, number in sensor.values.items()}
