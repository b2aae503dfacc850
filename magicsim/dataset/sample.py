"""The unit of work: one episode, simulated in whatever process, as the bytes of its rows."""

from dataclasses import dataclass
from typing import Any

from magicsim.dataset.features import Column
from magicsim.dataset.recipes.draw import DrawnEpisode


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTask:
    """One episode and how its rows are written."""

    episode: DrawnEpisode
    columns: list[Column]
    constants: dict[str, Any]
    """Columns that are the same in the whole dataset."""


def simulate_sample(task: SampleTask) -> bytes:
    """Simulates one episode.

    Returns:
        A Parquet file with one row a frame.

    Raises:
        MagicsimError: The episode has no valid answer, and trying again would not help.
    """
    from magicsim.camera.calibration import calibrate_camera
    from magicsim.dataset.rows import drawn_columns, episode_table
    from magicsim.dataset.shard import rows_as_bytes
    from magicsim.light.records.untouched_states import shared_states
    from magicsim.simulation.plan import plan_scene
    from magicsim.simulation.sensor import Sensor
    from magicsim.simulation.stream import stream_frames

    episode = task.episode
    scene = episode.scene
    frames = list(stream_frames(Sensor.for_scene(scene, untouched=shared_states()), plan_scene(scene)))
    constants = task.constants | drawn_columns(episode.values)
    constants |= {"episode": episode.index, "sensor": episode.sensor, "path_kind": episode.path_kind}
    calibration = calibrate_camera(scene.design, scene.rig)
    return rows_as_bytes(episode_table(frames, scene, calibration, task.columns, constants))
