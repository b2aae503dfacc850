"""A small sensor, and a made-up model of its touches whose network adds a known colour where the face touches."""

from pathlib import Path

import numpy as np

from magicsim.emulator.model import ModelFacts, TouchModel, coarse, rest_key, sensor_facts
from magicsim.scenes.scene import SceneConfig, load_scene

NETWORK = Path(__file__).with_name("contact.onnx")
COLOUR = (0.1, 0.2, 0.3)
SMALL = (
    "rig.camera.columns=48", "rig.camera.rows=64", "rig.camera.read_noise_e=0", "references=1",
    "render.samples=1", "render.particles=1000", "render.anchor_samples=2", "render.anchor_particles=2000",
    "rig.room=dark", "design.lattice.cells_across=0",
)  # fmt: skip


def small_scene(*settings: str) -> SceneConfig:
    """A ball pressed into the default sensor, filmed by a small camera in the dark."""
    return load_scene("pressed", [*SMALL, *settings], seed=1)


def small_model(scene: SceneConfig, rest: np.ndarray, **changed: object) -> TouchModel:
    """A model that knows this sensor alone."""
    sensor = {
        name: value if isinstance(value, str) else (value, value)
        for name, value in sensor_facts(scene.design, scene.rig).items()
    }
    facts = {
        "name": "made up", "sensor": sensor, "rest_key": rest_key(scene.design, scene.rig), "rooms": ["dark"],
        "kinds": ["sphere"], "depth_mm": 1.5, "specular": 0.0, "spacing_mm": 1.0, "touches": 1, "versions": {},
    }  # fmt: skip
    return TouchModel(facts=ModelFacts(**(facts | changed)), network=NETWORK.read_bytes(), rest=coarse(rest))
