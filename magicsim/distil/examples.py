"""True touches that a network learns from: what each changes of the image, and the fields that physics gives.

A change is what a touched frame differs by from the object just before contact, with no noise taken out: noisy, but
right in the mean, which is what least squares find.
"""

import io
import json
from copy import copy
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import AnyArray
from magicsim.camera.projection import pixel_landing_mm
from magicsim.dataset.recipes.draw import DrawnEpisode
from magicsim.dataset.rows import at_force
from magicsim.emulator.fields import FieldMaker, Fields
from magicsim.errors import ConvergenceError, RenderError
from magicsim.light.records.untouched import shared_states
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.emulation import before_contact
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.truth import contact_mask

LEAST_NEWTON = 0.01
"""Force below which nothing touches [N]."""
MOST_NEWTON = 10.0
"""Force at which a press ends [N]: prints bear 6 (Fan, Li, Zhang, arXiv 2505.24382)."""
HELD_OUT_EVERY = 8
"""Every so manieth example is none to learn from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExampleTask:
    """One episode of touches."""

    number: int
    episode: DrawnEpisode
    images: int = 1
    """Independent images of each touch; two tell an error from their noise."""


ARRAYS = {"displacements": np.float16, "free": np.float16, "mask": np.bool_, "change": np.float16, "tier": np.float16,
          "rest": np.float32, "nodes": np.float32}  # fmt: skip
"""What a file holds, in which precision: half of it is a tenth of a linear grey level's noise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Example:
    """Touches of one object at one place; radiance is in units of the mean untouched one."""

    facts: dict[str, Any]
    displacements: AnyArray
    """Displacements of the design's lattice, shape (touches, nodes, 3) [mm]."""
    free: AnyArray
    """Just before contact, shape (touches, rows, columns, 3)."""
    mask: AnyArray
    """Where the face touches, shape (touches, rows, columns)."""
    change: AnyArray
    """Changes of each touch, by each image, shape (touches, images, rows, columns, 3)."""
    tier: AnyArray
    """Changes that a frame of the true tier shows, shape (touches, rows, columns, 3); empty where only one image is."""
    rest: AnyArray
    """The untouched image, shape (rows, columns, 3)."""
    nodes: AnyArray

    def to_bytes(self) -> bytes:
        """The example as a file of NumPy."""
        file = io.BytesIO()
        arrays: dict[str, Any] = {name: np.asarray(getattr(self, name), kind) for name, kind in ARRAYS.items()}
        np.savez(file, facts=np.array(json.dumps(self.facts)), **arrays)
        return file.getvalue()

    @classmethod
    def read(cls, content: bytes) -> Self:
        """From such a file."""
        with np.load(io.BytesIO(content), allow_pickle=False) as data:
            return cls(facts=json.loads(str(data["facts"])), **{name: data[name] for name in ARRAYS})

    def maker(self) -> FieldMaker:
        """What makes fields of its touches."""
        scene = SceneConfig.model_validate(self.facts["scene"])
        return FieldMaker.of(scene.design, scene.rig, self.nodes.astype(np.float64), self.rest)

    def fields(self, maker: FieldMaker, touch: int) -> tuple[Fields, npt.NDArray[np.float32]]:
        """Fields and gate of one touch."""
        free = self.free[touch].astype(np.float32)
        return maker.make(self.displacements[touch].astype(np.float32), free, self.mask[touch])


def is_held_out(number: int) -> bool:
    """Whether an example is for measuring alone."""
    return number % HELD_OUT_EVERY == HELD_OUT_EVERY - 1


def render_example(task: ExampleTask) -> bytes:
    """Renders one episode's touches; a `MagicsimError` where it has no valid answer."""
    scene = at_force(task.episode)[0].scene
    sensor = Sensor.for_scene(scene, untouched=shared_states())
    rest = sensor.radiance(UNTOUCHED, sensor.rest)
    scale = float(rest.mean())
    landing_mm = pixel_landing_mm(sensor.design, sensor.rig.lens, sensor.rig.camera)
    # Where a frame of the true tier is judged by two images, none of them has its random numbers.
    noisy = [_with_noise(sensor, turn) for turn in (range(1, 1 + task.images) if task.images > 1 else (0,))]
    rows: list[tuple[AnyArray, ...]] = []
    touches: list[dict[str, float]] = []
    deformation, free = sensor.rest, None
    for state in (each for each in timeline(scene) if each.can_touch):
        try:
            deformation = sensor.deform(state, deformation)
            force = float(np.linalg.norm(deformation.force_n))
            if force < LEAST_NEWTON:
                continue
            if force > MOST_NEWTON:
                break
            now = [each.radiance(state, deformation) for each in noisy]
        except (ConvergenceError, RenderError):  # deeper ones have no answer either
            break
        lifted = before_contact(state)
        if lifted != free:
            free, before = lifted, sensor.radiance(lifted, sensor.rest)
        tier = sensor.radiance(state, deformation) - before if task.images > 1 else rest[:0]
        rows.append(
            (
                sensor.printed_displacements_mm(deformation), before / scale, contact_mask(deformation, landing_mm),
                np.stack([each - before for each in now]) / scale, tier / scale,
            )
        )  # fmt: skip
        touches.append({"depth_mm": -float(state.gap_mm or 0), "force_n": force})
    if not rows:
        raise ConvergenceError("nothing touches in this episode")
    target = scene.object
    facts = {
        "number": task.number, "touches": touches, "scene": scene.model_dump(mode="json"), "room": scene.rig.room or "",
        "kind": target.kind if target is not None else "", "specular": target.specular if target is not None else 0.0,
        "spacing_mm": getattr(target, "spacing_mm", None), "scale": scale,
    }  # fmt: skip
    arrays = dict(
        zip(("displacements", "free", "mask", "change", "tier"), map(np.stack, zip(*rows, strict=True)), strict=True)
    )
    return Example(facts=facts, rest=rest / scale, nodes=sensor.printed.nodes_mm, **arrays).to_bytes()


def _with_noise(sensor: Sensor, turn: int) -> Sensor:
    """The sensor, its first turn with the frame's own random numbers, but with all noise in its frames."""
    other = copy(sensor)
    other.renderer = sensor.renderer.reseeded(seed=sensor.seed + turn)
    other.renderer.leaves_out_noise = False
    return other
