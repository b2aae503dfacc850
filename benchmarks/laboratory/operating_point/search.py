"""One step of the search: a choice of all constants, filmed once and read through many cameras."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from laboratory.operating_point.draws import first_points, next_point
from laboratory.operating_point.filming import LAMPS, PRINT, FilmedStates, film_states, scene_fields
from laboratory.operating_point.reading import Reading, crosstalk_matrix, read_states
from laboratory.operating_point.targets import total_distance
from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import Dust, Flicker, Glare, LedDrift, LiveExposure, Mjpeg
from magicsim.conventions import IMAGE_COLUMNS
from magicsim.detectors import DetectorProfile
from magicsim.detectors.profile import Polarity, Similarity
from magicsim.errors import FrameError, RenderError
from magicsim.fit.constants import CONSTANTS, Constant, with_values
from magicsim.scenes.scene import SceneConfig

Array = npt.NDArray[np.float64]
T = TypeVar("T")
OPTICAL = (
    "body_ior", "infill_ior", "infill_scattering", "body_scattering", "body_absorption", "infill_absorption", "wall",
    "strip_margin", "strip_reflectance", "lens",
)  # fmt: skip
"""Constants that need a rendering of their own."""
CHOICES = {
    "strip_coupling": ("rig.strips.*.coupling", ("contact", "air")),
    "contact_coupling": ("contact.coupling", ("wet", "dry")),
    "room": ("rig.room", ("office", "window", "bench", None)),
    "lamps": (LAMPS, ("strips", "leds")),
    "print": (PRINT, ("smooth", "rough")),
}
"""Choices that do as well: their field, or what `film_states` makes of it, and what it may be."""
WALLS_MM = (0.1, 0.15, 0.2)
"""Walls are drawn from these alone, since each needs a deformation of its own."""
CAMERA = ("exposure", "gamma", "full_well", "read_noise")
"""Constants of the camera, which need none."""
EXTRA = {
    "crosstalk": Constant(path="crosstalk", low=0.0, high=0.3),
    "flashlight": Constant(path="flashlight", low=0.1, high=30.0, scale="log"),
    "ambient": Constant(path="ambient", low=0.003, high=1.0, scale="log"),
}
"""Beside them: see `laboratory.operating_point.reading.read_states`."""
EFFECTS = {
    "flicker": Constant(path="flicker.depth", low=0.0, high=0.4),
    "led_drift": Constant(path="led_drift.share", low=0.0, high=0.01),
    "glare": Constant(path="glare.share", low=0.0, high=0.1),
    "vibration": Constant(path="vibration_px", low=0.0, high=0.1),
    "dust": Constant(path="dust.opacity", low=0.0, high=0.5),
}
"""What a camera does besides, over the ranges that its settings name; none of it at the lower end."""
MAINS_HZ = 60.0
"""Of the room's lamps: an exposure of 20 ms, two periods of 50 Hz lamps, would hide those."""
COMPRESSIONS: tuple[Mjpeg | None, ...] = (None, Mjpeg(kind="mjpeg", quality=95), Mjpeg(kind="mjpeg", quality=70))
READINGS: tuple[tuple[Polarity, Similarity], ...] = (("dark", "recall"), ("dark", "iou"), ("bright", "iou"))
"""Readings of S that the publication leaves open and that can fall where a frame brightens: polarity and similarity."""
OPTICAL_NAMES = (*OPTICAL, *CHOICES)
LEFT_OUT: Mapping[str, Mapping[str, float]] = {
    "light of the room": {"ambient": 0.0},
    "crosstalk of the colours": {"crosstalk": 0.0},
    "noise of the camera": {"full_well": 1.0, "read_noise": 0.0},
    "an exposure below 90": {"exposure": 0.5},
    "a tone curve": {"gamma": 0.0},
    "an exposure that follows": {"live": 0.0},
    "another reading of S than dark, recall": {"grid_reading": 0.0},
    "flicker of the room": {"flicker": 0.0},
    "drift of the LEDs": {"led_drift": 0.0},
    "glare": {"glare": 0.0},
    "vibration": {"vibration": 0.0},
    "dust": {"dust": 0.0},
    "compression": {"compression": 0.0},
    "single LEDs": {"lamps": 0.0},
    "a rough print": {"print": 0.0},
    "air before the strips": {"strip_coupling": 0.0},
    "a dry object": {"contact_coupling": 0.0},
}
"""Mechanisms, and the share of a constant's range that has them not."""
ROUNDS = 4
"""Of drawing cameras in one step."""
EXPOSURES: tuple[LiveExposure | None, ...] = (None, LiveExposure(white_balance=False), LiveExposure())
"""Locked, live, live with white balance."""
EFFECT_NAMES = (*EFFECTS, "compression")
CAMERA_NAMES = (*EFFECT_NAMES, *CAMERA, *EXTRA, "live", "grid_reading")


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """All constants of one sensor, as a point of the unit cube, and what was read of it."""

    optical: list[float]
    """Shares of the ranges of `OPTICAL_NAMES`."""
    camera: list[float]
    """Shares of the ranges of `CAMERA_NAMES`."""
    distance: float
    """Root mean square distance from the targets [tolerances]."""
    reading: Reading

    @classmethod
    def read_back(cls, data: Mapping[str, Any]) -> "Candidate":
        """From what `asdict` made of it."""
        return cls(**{**data, "reading": Reading(**data["reading"])})


def optical_fields(point: Sequence[float]) -> dict[str, object]:
    """Values of a scene's fields at shares of the ranges of `OPTICAL_NAMES`."""
    shares = dict(zip(OPTICAL_NAMES, point, strict=True))
    fields: dict[str, object] = {CONSTANTS[name].path: constant_at(name, shares[name]) for name in OPTICAL}
    return fields | {path: _chosen(options, shares[name]) for name, (path, options) in CHOICES.items()}


def camera_values(point: Sequence[float]) -> dict[str, float]:
    """Values at shares of the ranges of `CAMERA_NAMES`, by name; the reading of S left out."""
    shares = dict(zip(CAMERA_NAMES, point, strict=True))
    return {name: constant_at(name, shares[name]) for name in (*CAMERA, *EXTRA)}


def constant_at(name: str, share: float) -> float:
    """Value of a constant at a share of its range."""
    return _chosen(WALLS_MM, share) if name == "wall" else ((EXTRA | EFFECTS).get(name) or CONSTANTS[name]).at(share)


def value_at(name: str, share: float) -> float | str:
    """Value of a constant, or the choice, at a share of its range."""
    if name == "grid_reading":
        return " ".join(_chosen(READINGS, share))
    if name == "live":
        return _chosen(("locked", "live exposure", "live exposure and white balance"), share)
    if name == "compression":
        chosen = _chosen(COMPRESSIONS, share)
        return "none" if chosen is None else f"mjpeg {chosen.quality}"
    return str(_chosen(CHOICES[name][1], share)) if name in CHOICES else constant_at(name, share)


def effects(point: Sequence[float], camera: Camera) -> dict[str, object]:
    """Settings of a camera's effects at shares of the ranges of `CAMERA_NAMES`; what is none is left out.

    Args:
        point: The shares.
        camera: Which one; pixels of the default's image count, whose part of the field is kept.
    """
    scale = camera.columns / IMAGE_COLUMNS
    shares = dict(zip(CAMERA_NAMES, point, strict=True))
    values = {name: constant_at(name, shares[name]) for name in EFFECTS}
    found: dict[str, object] = {
        "vibration_px": scale * values["vibration"], "compression": _chosen(COMPRESSIONS, shares["compression"])
    }  # fmt: skip
    tables: dict[str, object] = {
        "flicker": Flicker(depth=values["flicker"], mains_hz=MAINS_HZ),
        "led_drift": LedDrift(share=values["led_drift"]),
        "glare": Glare(share=values["glare"], radius_px=scale * Glare().radius_px),
        "dust": Dust(opacity=values["dust"], radius_px=scale * Dust().radius_px),
    }
    return found | {name: table for name, table in tables.items() if values[name] > 0}


def camera_at(point: Sequence[float], camera: Camera) -> Camera:
    """A camera with all that is drawn of one but crosstalk, at shares of the ranges of `CAMERA_NAMES`."""
    values = camera_values(point)
    changes: dict[str, object] = {CONSTANTS[name].path.rpartition(".")[2]: values[name] for name in CAMERA}
    return camera.model_copy(update=changes | effects(point, camera) | {"live": exposing(point)})


def exposing(point: Sequence[float]) -> LiveExposure | None:
    """How the camera at these shares follows what it sees."""
    return _chosen(EXPOSURES, point[CAMERA_NAMES.index("live")])


def grid_reading(point: Sequence[float]) -> tuple[Polarity, Similarity]:
    """Polarity and similarity at the last of these shares."""
    return _chosen(READINGS, point[-1])


def candidate(
    states: FilmedStates, scene: SceneConfig, optical: Sequence[float], camera: Sequence[float],
    profile: DetectorProfile,
) -> Candidate | None:  # fmt: skip
    """Reads filmed states through one camera; None where it shows no grid.

    Args:
        states: Of the optical constants.
        scene: Whose camera gives what is not drawn.
        optical: Shares of the ranges of `OPTICAL_NAMES`.
        camera: Shares of the ranges of `CAMERA_NAMES`.
        profile: Options of the detectors.
    """
    values = camera_values(camera)
    polarity, similarity = grid_reading(camera)
    try:
        reading = read_states(
            states,
            camera_at(camera, scene.rig.camera),
            ambient=values["ambient"],
            flashlight=values["flashlight"],
            crosstalk=values["crosstalk"],
            profile=replace(profile, polarity=polarity, similarity=similarity),
        )
    except (FrameError, RenderError):
        return None
    return Candidate(
        optical=list(optical), camera=list(camera), distance=total_distance(reading.quantities), reading=reading
    )


def sensor_scene(scene: SceneConfig, optical: Sequence[float], camera: Sequence[float]) -> SceneConfig:
    """A scene with all constants of a sensor, its reading of S left out.

    Args:
        scene: What happens, with the default sensor.
        optical: Shares of the ranges of `OPTICAL_NAMES`.
        camera: Shares of the ranges of `CAMERA_NAMES`.
    """
    values, lamps = camera_values(camera), scene.rig.flashlight
    with_optics = with_values(scene, scene_fields(scene, optical_fields(optical)))
    seen = camera_at(camera, scene.rig.camera).model_copy(
        update={"color_matrix": crosstalk_matrix(values["crosstalk"])}
    )
    strength = tuple(values["flashlight"] * each for each in lamps.radiance)
    rig = with_optics.rig.model_copy(
        update={
            "camera": seen,
            "ambient": (values["ambient"],) * 3,
            "flashlight": lamps.model_copy(update={"radiance": strength}),
        }
    )
    return with_optics.model_copy(update={"rig": rig})


def search_step(
    scene: SceneConfig, profile: DetectorProfile, good: Sequence[Candidate], *, aim: Callable[[Candidate], float],
    index: int, first: int, cameras: int, seed: int,
) -> list[Candidate]:  # fmt: skip
    """Films one choice of the optical constants and reads it through several cameras, those without a grid left out.

    Cameras are cheap beside a filming: those of later steps are drawn in `ROUNDS`, the first around the good ones of
    other filmings, the others around the best of this one.

    Args:
        scene: From `laboratory.operating_point.filming.search_scene`.
        profile: Options of the detectors.
        good: The best candidates so far, one for each filming; used from step `first` on.
        aim: What is to be small.
        index: Number of the step; a step depends on `seed`, `index` and `good` alone.
        first: Number of steps whose points cover the ranges evenly.
        cameras: Cameras to read through.
        seed: Of the search.
    """
    even = index < first or not good
    if even:
        optical = first_points(index + 1, len(OPTICAL_NAMES), seed=seed)[index]
    else:
        optical = next_point([np.array(each.optical) for each in good], seed=seed, index=2 * index)
    states = film_states(scene, optical_fields(optical.tolist()))
    found: list[Candidate] = []
    for turn in range(1 if even else ROUNDS):
        points = list(first_points(cameras, len(CAMERA_NAMES), seed=seed + 1 + index)) if turn == 0 else []
        best = sorted(found, key=aim)[: len(good)] if turn > 0 else good
        if best and not even:
            known, place = [np.array(each.camera) for each in best], (index * ROUNDS + turn) * cameras
            near = [next_point(known, seed=seed, index=2 * (place + each) + 1) for each in range((cameras + 1) // 2)]
            points = [*points[1::2], *near]
        every = [candidate(states, scene, optical.tolist(), each.tolist(), profile) for each in points]
        found += [each for each in every if each is not None]
    return found


def left_out(best: Candidate, scene: SceneConfig, profile: DetectorProfile) -> dict[str, float | None]:
    """Distance of a sensor without each mechanism that it has [tolerances]; None where it shows no grid then."""
    found: dict[str, float | None] = {}
    states = None
    for name, change in LEFT_OUT.items():
        optical, camera = (
            [change.get(each, share) for each, share in zip(names, shares, strict=True)]
            for names, shares in ((OPTICAL_NAMES, best.optical), (CAMERA_NAMES, best.camera))
        )
        if all(value_at(each, share) == value_at(each, _share(best, each)) for each, share in change.items()):
            continue
        if optical != best.optical:
            filmed = film_states(scene, optical_fields(optical))
        else:
            filmed = states = states or film_states(scene, optical_fields(optical))
        read = candidate(filmed, scene, optical, camera, profile)
        found[name] = None if read is None else read.distance
    return found


def _share(sensor: Candidate, name: str) -> float:
    names = dict(zip((*OPTICAL_NAMES, *CAMERA_NAMES), (*sensor.optical, *sensor.camera), strict=True))
    return names[name]


def as_row(candidates: Sequence[Candidate]) -> list[dict[str, Any]]:
    """Plain data, best first, figures rounded to what they are worth."""
    return [_rounded(asdict(each)) for each in sorted(candidates, key=lambda each: each.distance)]


def _chosen(options: Sequence[T], share: float) -> T:
    return options[min(int(share * len(options)), len(options) - 1)]


def _rounded(value: Any) -> Any:  # noqa: ANN401 - nested plain data
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    return [_rounded(each) for each in value] if isinstance(value, list) else value
