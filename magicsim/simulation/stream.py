"""From a scene to its frames and ground truth: the chain that everything else builds on."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import accumulate

from magicsim.arrays import FloatImage
from magicsim.camera.stream import Instant
from magicsim.deform.deformation import Deformation
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, Origin
from magicsim.simulation.episode import Episode, SimulatedFrame
from magicsim.simulation.labelled_frame import Shot
from magicsim.simulation.plan import UNTOUCHED_FRAME, ScenePlan, plan_scene
from magicsim.simulation.sensor import Sensor, sensor_camera
from magicsim.waiting import Told, on_stderr, unheard, waiting

Progress = Callable[[int, int], None]
"""Called after every frame with the work done and all work, in the same arbitrary unit."""


def simulate(
    scene: SceneConfig, *, plan: ScenePlan | None = None, progress: Progress | None = None, told: Told = on_stderr
) -> Episode:
    """Simulates a whole scene.

    Args:
        scene: What happens, on which sensor.
        plan: Which work to do; by default only what the scene needs.
        progress: Told after every frame.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
    """
    with waiting("simulating", told if progress is None else unheard) as share:
        plan = plan or plan_scene(scene)
        return simulate_with(Sensor.for_scene(scene), plan, progress=progress or share)


def simulate_with(sensor: Sensor, plan: ScenePlan, *, progress: Progress | None = None) -> Episode:
    """Simulates a planned scene with its sensor, already built; see `simulate`."""
    scene = plan.scene
    sensor.warm_up([frame.state for frame in plan.frames if frame.same_as is None])
    start = time.perf_counter()
    work = list(accumulate(plan.efforts))
    frames = []
    for frame, done in zip(stream_frames(sensor, plan), work, strict=True):
        frames.append(frame)
        if progress is not None:
            progress(done, work[-1])
    return Episode(scene=scene, frames=tuple(frames), seconds=time.perf_counter() - start)


@dataclass(frozen=True, slots=True, kw_only=True)
class RenderedState:
    """One frame of the stream before the camera: everything that noise and exposure do not change."""

    state: FrameState
    deformation: Deformation
    radiance: FloatImage
    """Linear radiance, shape (rows, columns, 3); the same array for all frames that look the same."""
    origin: Origin
    """How it was made."""
    index: int
    """Place in the stream, reference frames included."""
    is_reference: bool


def stream_states(sensor: Sensor, plan: ScenePlan, untouched: tuple[FloatImage, Origin]) -> Iterator[RenderedState]:
    """Rendered states of an episode in order: the references, then what the plan lists.

    Args:
        sensor: That of the scene.
        plan: Which work to do.
        untouched: Radiance of the sensor at rest, shape (rows, columns, 3), and how it was made.
    """
    first, deformation = len(plan.references), sensor.rest
    reused, rendered = {frame.same_as for frame in plan.frames}, {UNTOUCHED_FRAME: untouched}
    for number, frame in enumerate((*plan.references, *plan.frames), -first):
        if frame.solve:
            deformation = sensor.deform(frame.state, deformation)
        else:
            deformation = replace(deformation, iterations=0) if frame.state.can_touch else sensor.rest
        known = rendered[frame.same_as] if frame.same_as is not None else None
        radiance, origin = known or sensor.render(frame.state, deformation)
        if number >= 0 and number in reused:
            rendered[number] = radiance, origin
        yield RenderedState(
            state=frame.state,
            deformation=deformation,
            radiance=radiance,
            origin=origin,
            index=first + number,
            is_reference=number < 0,
        )


def stream_frames(sensor: Sensor, plan: ScenePlan) -> Iterator[SimulatedFrame]:
    """The frames of an episode in order: the references, then what the plan lists.

    A camera with a history (`Camera.history`) makes another frame of a state that returns, so all are exposed in order.
    """
    scene = plan.scene
    untouched = sensor.render(UNTOUCHED, sensor.rest)
    touch = sensor.touch_truth(scene.output.taxels) if scene.output.taxels is not None else None
    shot = Shot.of(scene.design, scene.rig, scene.output, sensor_camera(sensor, untouched[0]))
    memory = shot.camera.begin(scene.frames_per_second)
    for each in stream_states(sensor, plan, untouched):
        at = Instant(
            seed=scene.seed,
            index=each.index,
            time_s=each.index / scene.frames_per_second,
            frames_per_second=scene.frames_per_second,
        )
        frame, memory = shot.take(
            each.state,
            each.deformation,
            each.radiance,
            memory,
            at,
            displacements_mm=sensor.printed_displacements_mm(each.deformation) if scene.output.displacements else None,
            is_reference=each.is_reference,
            origin=each.origin,
            markers_mm=sensor.markers_mm(each.deformation),
            touch=touch.fields(each.deformation) if touch is not None else None,
        )
        yield frame
