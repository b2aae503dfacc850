"""What one simulated episode holds: frames and ground truth."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Frame, Mask
from magicsim.deform.deformation import SolveFigures
from magicsim.errors import OutputError
from magicsim.folder import result_file
from magicsim.frame_class import FrameClass, frame_label
from magicsim.notebook import picture_row
from magicsim.notebook.screen import beside_change
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNKNOWN_ORIGIN, FrameState, Origin
from magicsim.simulation.touch_truth import TouchFields

Vector = tuple[float, float, float]
ScalarT = TypeVar("ScalarT", bound=np.generic)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameTruth:
    """Ground truth of one frame."""

    index: int
    """Place in the stream, reference frames included."""
    time_s: float
    """Time from the first frame of the stream [s]."""
    is_reference: bool
    """Whether the frame belongs to the references; such a frame is never scored."""
    state: FrameState
    """Where the object and the light are."""
    contact: bool
    """Whether a contact force acts."""
    depth_mm: float
    """Indentation depth, -gap where pressed and 0 elsewhere [mm]."""
    force_n: Vector
    """Force of the object on the sensor [N]."""
    torque_nmm: Vector
    """Torque of that force about the origin [N mm]."""
    contact_area_mm2: float
    """Deformed area of the face that touches [mm2]."""
    frame_class: FrameClass | None
    """Class for scoring, None where the frame is not scored."""
    solve: SolveFigures
    """Quality of the deformation."""
    beyond_limits: str = ""
    """What of the touch is above the design's limits, see `PressLimits.excess`; empty where nothing is."""
    dissipated_nmm: float | None = None
    """Energy that the infill has turned into heat since the first touch [N mm]; None before it, or where none flows."""

    @property
    def label(self) -> str:
        """The class as tables name it: `Light touch` where a touch is not scored, empty for references."""
        return frame_label(self.frame_class, touches=self.contact and not self.is_reference)

    @property
    def gap_mm(self) -> float | None:
        """Distance of the object from the untouched face, negative where it is pressed in; None without one [mm]."""
        return self.state.gap_mm

    @property
    def caption(self) -> str:
        """Where the object is and what it does, in a few words."""
        gap = self.state.gap_mm
        if gap is None:
            return "flashlight" if self.state.flashlight else "untouched"
        place = f"gap {gap:.2g} mm" if gap > 0 else f"{self.depth_mm:.2g} mm deep, {self.force_n[2]:.2g} N"
        return f"{place}, flashlight" if self.state.flashlight else place


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameLabels:
    """Labels of one frame: `in_view` always, the others only where a scene's `[output]` asks (None: it did not)."""

    contact_mask: Mask | None = None
    """Pixels whose ray meets the contact, shape (rows, columns)."""
    displacements_mm: npt.NDArray[np.float32] | None = None
    """Lattice displacements, shape (nodes, 3) [mm]."""
    depth_map_mm: npt.NDArray[np.float32] | None = None
    """How far the contact face is pressed in at each pixel, shape (rows, columns) [mm]."""
    markers_mm: Array | None = None
    """Centres of the markers in the sensor's frame, displaced, shape (markers, 3) [mm]; None without markers."""
    markers_px: Array | None = None
    """Where the camera sees them, column and row, whole at pixel centres, shape (markers, 2) [px]."""
    touch: TouchFields | None = None
    """Forces on taxels, stretch and stress of the skin, shear of the infill."""
    in_view: bool = True
    """Whether the picture covers the place that the object touches or stands before; true without an object."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedFrame:
    """One frame of the stream with everything known about it."""

    image: Frame
    """RGB, shape (rows, columns, 3)."""
    truth: FrameTruth
    labels: FrameLabels
    """What was asked for beside them; the properties below refuse what was not."""
    origin: Origin = UNKNOWN_ORIGIN
    """How light and image were made, of which a network must not learn."""

    @property
    def contact_mask(self) -> Mask:
        """Pixels whose ray meets the contact, shape (rows, columns); `OutputError` unless the scene asks for it."""
        return _asked_for(self.labels.contact_mask, "contact_mask", "output.contact_mask")

    @property
    def displacements_mm(self) -> npt.NDArray[np.float32]:
        """Lattice displacements, shape (nodes, 3) [mm]; `OutputError` unless the scene asks for them."""
        return _asked_for(self.labels.displacements_mm, "displacements_mm", "output.displacements")

    @property
    def depth_map_mm(self) -> npt.NDArray[np.float32]:
        """How far the face is pressed in at each pixel, shape (rows, columns) [mm]; else as `contact_mask`."""
        return _asked_for(self.labels.depth_map_mm, "depth_map_mm", "output.depth_map")

    @property
    def touch(self) -> TouchFields:
        """Forces on taxels, stretch and stress of the skin, shear of the infill; else as `contact_mask`."""
        if self.labels.touch is None:
            raise OutputError(
                "touch was not computed: add [output.taxels] with rows and columns to the scene, or "
                "--set output.taxels.rows=16"
            )
        return self.labels.touch


def _asked_for(found: npt.NDArray[ScalarT] | None, name: str, setting: str) -> npt.NDArray[ScalarT]:
    if found is None:
        raise OutputError(f"{name} was not computed: set {setting} = true in the scene, or --set {setting}=true")
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """All frames of one scene, references first."""

    scene: SceneConfig
    frames: tuple[SimulatedFrame, ...]
    seconds: float = 0.0
    """Warm cost of all frames, without compilation and scene build [s]."""

    def __repr__(self) -> str:
        """How many frames, and what happens in them; no arrays."""
        extremes, gaps = "", [frame.truth.gap_mm for frame in self.scored if frame.truth.gap_mm is not None]
        if gaps:
            force = max(frame.truth.force_n[2] for frame in self.scored)
            extremes = f", gaps {min(gaps):g} to {max(gaps):g} mm, normal force up to {force:.3g} N"
        return f"Episode({len(self.references)} references and {len(self.scored)} frames{extremes})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the story in a few pictures."""
        frames = story_frames(self.scored or self.frames)
        captions = [frame.truth.caption for frame in frames]
        row = picture_row(list(zip(self.on_screen(frames), captions, strict=True)))
        return f"<div><b>{escape(repr(self))}</b></div>{row}"

    @property
    def rest(self) -> Array | None:
        """Mean of the reference frames, shape (rows, columns, 3) [grey levels]; None without any."""
        references = [frame.image for frame in self.references]
        return np.mean(references, axis=0) if references else None

    def on_screen(self, frames: Sequence[SimulatedFrame]) -> list[Frame]:
        """Frames as a screen shows them, each beside its change: `magicsim.notebook.screen.beside_change`."""
        rest, gamma = self.rest, self.scene.rig.camera.gamma
        return [beside_change(frame.image, rest, gamma=gamma) for frame in frames]

    @property
    def images(self) -> Frame:
        """All frames in order, shape (frames, rows, columns, 3)."""
        return np.stack([frame.image for frame in self.frames])

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Images and truth as arrays with one entry a frame: `images`, and what `truth_arrays` gives."""
        return {"images": self.images, **truth_arrays([frame.truth for frame in self.frames])}

    def save(self, path: Path) -> None:
        """Writes `arrays` to an `.npz` file, whole or not at all (`OutputError`), over none that is not magicsim's."""
        with result_file(path) as partial, partial.open("wb") as file:
            np.savez_compressed(file, **self.arrays())  # type: ignore[arg-type]

    @property
    def references(self) -> tuple[SimulatedFrame, ...]:
        """Frames of the untouched sensor that the detectors learn from."""
        return tuple(frame for frame in self.frames if frame.truth.is_reference)

    @property
    def scored(self) -> tuple[SimulatedFrame, ...]:
        """The frames after the references."""
        return tuple(frame for frame in self.frames if not frame.truth.is_reference)


def frame_file(index: int) -> str:
    """Name of a frame's image inside the episode's folder."""
    return f"frames/{index:05d}.png"


def truth_row(frame: SimulatedFrame) -> dict[str, Any]:
    """Columns that the tables of episodes and of datasets share; the gap is None without an object."""
    truth, state = frame.truth, frame.truth.state
    return {
        "step": truth.index, "time_s": truth.time_s, "is_reference": truth.is_reference,
        "frame_class": truth.label, "gap_mm": state.gap_mm, "twist_deg": state.twist_deg,
        "flashlight": state.flashlight, "contact": truth.contact, "depth_mm": truth.depth_mm,
        "force_n": list(truth.force_n), "torque_nmm": list(truth.torque_nmm),
        "contact_area_mm2": truth.contact_area_mm2, "beyond_limits": bool(truth.beyond_limits),
        "in_view": frame.labels.in_view, "light_way": frame.origin.light, "image_way": frame.origin.image,
        "dissipated_nmm": math.nan if truth.dissipated_nmm is None else truth.dissipated_nmm,
        **asdict(truth.solve),
    }  # fmt: skip


def truth_arrays(truths: Sequence[FrameTruth]) -> dict[str, npt.NDArray[Any]]:
    """Ground truth as arrays with one entry a frame.

    Returns:
        `time_s`, `is_reference`, `gap_mm` (NaN without an object), `depth_mm`, `force_n` and `torque_nmm` of shape
        (frames, 3), `contact_area_mm2`, `contact`, `flashlight`, `frame_class` (`FrameTruth.label`).
    """
    gaps = [each.state.gap_mm for each in truths]
    return {
        "time_s": np.array([each.time_s for each in truths]),
        "is_reference": np.array([each.is_reference for each in truths], bool),
        "gap_mm": np.array([np.nan if gap is None else gap for gap in gaps]),
        "depth_mm": np.array([each.depth_mm for each in truths]),
        "force_n": np.array([each.force_n for each in truths]).reshape(-1, 3),
        "torque_nmm": np.array([each.torque_nmm for each in truths]).reshape(-1, 3),
        "contact_area_mm2": np.array([each.contact_area_mm2 for each in truths]),
        "contact": np.array([each.contact for each in truths], bool),
        "flashlight": np.array([each.state.flashlight for each in truths], bool),
        "frame_class": np.array([each.label for each in truths], str),
    }


def story_frames(frames: Sequence[SimulatedFrame]) -> list[SimulatedFrame]:
    """The few frames that tell a story: first, nearest before contact, lightest and hardest touch, light, last."""
    gaps = {number: frame.truth.state.gap_mm for number, frame in enumerate(frames)}
    near = [number for number, gap in gaps.items() if gap is not None and gap > 0]
    touching = [number for number, frame in enumerate(frames) if frame.truth.contact]
    lit = [number for number, frame in enumerate(frames) if frame.truth.state.flashlight]
    chosen = {0, len(frames) - 1, *lit[:1], *touching[:1]}
    if near:
        chosen.add(min(near, key=lambda number: gaps[number] or 0.0))
    if touching:
        chosen.add(max(touching, key=lambda number: frames[number].truth.depth_mm))
    return [frames[number] for number in sorted(chosen)]
