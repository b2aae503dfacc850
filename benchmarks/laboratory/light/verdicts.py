"""How well must a frame be rendered? What the detectors read of five states, against samples and particles.

Every setting renders the states of independent seeds, anchored as in an episode; the last one stands for converged.
"""

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from laboratory.benchmark import logged, machine
from magicsim.camera.exposure import expose, meter
from magicsim.detectors import detect, fuse, load_profile
from magicsim.light.records.untouched_store import shared_states
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

STATES: dict[str, tuple[str, tuple[str, ...]]] = {
    "rest": ("rest", ()),
    "near": ("near", ()),
    "touched": ("pressed", ("keyframes=[{frame=0,gap_mm=-0.2}]",)),
    "pressed": ("pressed", ()),
    "flashlight": ("flashlight", ()),
}
"""Scene and settings of each."""
SETTINGS = ((1, 10_000), (2, 20_000), (4, 40_000), (8, 80_000), (16, 160_000), (32, 320_000), (64, 1_280_000))
"""Camera samples a pixel and light particles; the fourth is the default."""
PROFILE = "calibrated"
SEEDS, QUICK_SEEDS = 3, 2
REST_SEED = 1_000_000
"""The judged untouched frame is another episode's: its seed differs from the references' by this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictRow:
    """What the detectors read of one state at one setting; means over seeds, and standard deviations."""

    state: str
    samples: int
    particles: int
    seconds: float
    """Median time of light and camera for one frame, with the update of the meshes."""
    entropy: float
    entropy_sd: float
    correlation: float
    correlation_sd: float
    similarity: float
    similarity_sd: float
    verdicts: list[str]
    """Combined verdict of each seed."""


def run_verdicts(*, quick: bool = False) -> dict[str, Any]:
    """All settings on all states.

    Args:
        quick: A small image, few settings and seeds.
    """
    settings = SETTINGS[1:5:3] if quick else SETTINGS
    seeds = QUICK_SEEDS if quick else SEEDS
    rows = logged(
        measure_verdicts(state, *setting, seeds=seeds, quick=quick) for state in STATES for setting in settings
    )
    return {
        "kind": "verdicts",
        "quick": quick,
        "profile": PROFILE,
        "results": [asdict(row) for row in rows],
        "machine": machine(),
    }


def measure_verdicts(state: str, samples: int, particles: int, *, seeds: int, quick: bool = False) -> VerdictRow:
    """One row.

    Args:
        state: Key of `STATES`; the first scored frame.
        samples: Camera samples a pixel.
        particles: Light particles of all strips.
        seeds: Number of independent renderings.
        quick: A small image and a cheap anchor.
    """
    small = (
        ("rig.camera.columns=60", "rig.camera.rows=80", "render.anchor_samples=8", "render.anchor_particles=100000")
        if quick
        else ()
    )
    profile, found, seconds = load_profile(PROFILE), [], []
    for seed in range(seeds):
        name, changes = STATES[state]
        settings = [*changes, f"render.samples={samples}", f"render.particles={particles}", *small]
        scene = load_scene(name, settings, seed=seed)
        sensor, frame = Sensor.for_scene(scene, untouched=shared_states()), timeline(scene)[0]
        deformation = sensor.deform(frame, sensor.rest) if can_touch(frame) else sensor.rest
        view = sensor.view(frame, deformation)
        untouched = sensor.radiance(UNTOUCHED, sensor.rest)
        sensor.renderer.warm_up(view)
        sensor.renderer.prepare(view)
        start = time.perf_counter()
        radiance = sensor.radiance(frame, deformation)
        seconds.append(time.perf_counter() - start)
        camera, exposure = scene.rig.camera, meter(untouched, scene.rig.camera, scene.rig.lit)
        rest = [
            expose(untouched, exposure, camera, seed=seed, frame=number) for number in range(profile.reference_count)
        ]
        image = expose(radiance, exposure, camera, seed=seed + REST_SEED, frame=profile.reference_count)
        found.append(detect(image, fuse(rest, profile), profile))
    figures = {name: [getattr(one, name) for one in found] for name in ("entropy", "correlation", "similarity")}
    statistics = {name: float(np.mean(values)) for name, values in figures.items()}
    statistics |= {f"{name}_sd": float(np.std(values, ddof=1)) for name, values in figures.items()}
    return VerdictRow(
        state=state,
        samples=samples,
        particles=particles,
        seconds=float(np.median(seconds)),
        verdicts=[one.combined.value for one in found],
        **statistics,
    )
