"""The same episodes with one part of the physics taken away, to see which part the verdicts rest on."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from laboratory.ablation.membrane import shade_membrane
from magicsim.camera.projection import pixel_landing_mm
from magicsim.deform.deformation import Deformation
from magicsim.errors import MagicsimError, RenderError, unknown_choice
from magicsim.evaluation.take import Take, assembled, read_take, take_key, write_take
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import RenderedState, stream_states
from magicsim.simulation.truth import depth_map_mm

FloatImage = npt.NDArray[np.float32]
FLAT_GAP_MM = 0.02
"""Where an object stops that cannot deform the sensor [mm]: just outside, optically dry."""
Look = Callable[[FrameState, Deformation], FloatImage]
"""Radiance of a state, shape (rows, columns, 3)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """What is taken away."""

    says: str
    look: Callable[[SceneConfig], Look]
    """From the scene to how its states look."""


def _unscattered(scene: SceneConfig) -> SceneConfig:
    clear = {"sigma_s_per_mm": 0.0}
    return _with_materials(scene, body=clear, infill=clear)


def _unrefracted(scene: SceneConfig) -> SceneConfig:
    return _with_materials(scene, body={"ior": 1.0}, infill={"ior": 1.0})


def _matched(scene: SceneConfig) -> SceneConfig:
    return _with_materials(scene, body={}, infill={"ior": scene.design.materials.body.ior})


def _with_materials(scene: SceneConfig, *, body: Mapping[str, float], infill: Mapping[str, float]) -> SceneConfig:
    materials = scene.design.materials
    changed = materials.model_copy(
        update={
            "body": materials.body.model_copy(update=body),
            "infill": materials.infill.model_copy(update=infill) if materials.infill is not None else None,
        }
    )
    return scene.model_copy(update={"design": scene.design.model_copy(update={"materials": changed})})


def _white(scene: SceneConfig) -> SceneConfig:
    """Every strip emits the mean of its channels in all of them."""
    strips = tuple(each.model_copy(update={"radiance": (sum(each.radiance) / 3,) * 3}) for each in scene.rig.strips)
    return scene.model_copy(update={"rig": scene.rig.model_copy(update={"strips": strips})})


def _rendered(change: Callable[[SceneConfig], SceneConfig]) -> Callable[[SceneConfig], Look]:
    """The light of another sensor on the same deformations."""

    def look(scene: SceneConfig) -> Look:
        sensor = Sensor.for_scene(change(scene))
        return sensor.radiance

    return look


def _rigid(scene: SceneConfig) -> Look:
    sensor = Sensor.for_scene(scene)

    def radiance(state: FrameState, deformation: Deformation) -> FloatImage:
        del deformation
        outside = state if state.gap_mm is None else replace(state, gap_mm=max(state.gap_mm, FLAT_GAP_MM))
        return sensor.radiance(outside, sensor.rest)

    return radiance


def _membrane(scene: SceneConfig) -> Look:
    landing = pixel_landing_mm(scene.design, scene.rig.lens, scene.rig.camera)

    def radiance(state: FrameState, deformation: Deformation) -> FloatImage:
        del state
        flat = np.zeros(landing.shape[:2])
        depth = flat if deformation.is_rest else np.asarray(depth_map_mm(deformation, landing), float)
        return shade_membrane(depth, landing, scene.rig.strips)

    return radiance


NOTHING = "nothing"
"""Name of the unchanged physics."""
ABLATIONS: Mapping[str, Ablation] = {
    NOTHING: Ablation(says="the full physics", look=_rendered(lambda scene: scene)),
    "scattering": Ablation(says="neither infill nor body scatters", look=_rendered(_unscattered)),
    "deformation": Ablation(says="the object stops at the face", look=_rigid),
    "grid_refraction": Ablation(says="infill and body have one index", look=_rendered(_matched)),
    "refraction": Ablation(says="all indices are 1", look=_rendered(_unrefracted)),
    "colour": Ablation(says="all strips are white", look=_rendered(_white)),
    "transparency": Ablation(says="an opaque membrane shaded from its height map", look=_membrane),
}
"""What is taken away, by name."""


def film_ablated(scene: SceneConfig, names: Sequence[str], cache: Path) -> dict[str, Take | str]:
    """One take for each ablation, kept on disk; of what cannot be filmed the reason.

    The deformations are solved once for all: no ablation changes the mechanics.

    Args:
        scene: The episode.
        names: Keys of `ABLATIONS`.
        cache: Folder of takes.

    Raises:
        MagicsimError: The episode itself cannot be simulated, or the cache cannot be written.
    """
    for name in names:
        if name not in ABLATIONS:
            raise RenderError(unknown_choice("ablation", name, ABLATIONS))
    paths = {name: cache / f"{ablation_key(scene, name)}.npz" for name in names}
    found: dict[str, Take | str] = {name: read_take(path) for name, path in paths.items() if path.is_file()}
    missing = [name for name in names if name not in found]
    if not missing:
        return found
    sensor = Sensor.for_scene(scene)
    frames = list(stream_states(sensor, plan_scene(scene), sensor.render(UNTOUCHED, sensor.rest)))
    for name in missing:
        try:
            take = assembled(frames, _through(ABLATIONS[name].look(scene)))
        except MagicsimError as error:
            found[name] = str(error)
            continue
        write_take(paths[name], take)
        found[name] = take
    return found


def ablation_key(scene: SceneConfig, name: str) -> str:
    """Hash of everything that decides an ablated take."""
    return hashlib.sha256(f"{take_key(scene)} {name}".encode()).hexdigest()[:24]


def _through(look: Look) -> Callable[[RenderedState], FloatImage]:
    """A look at rendered states, of which it takes state and deformation alone."""
    return lambda each: look(each.state, each.deformation)
