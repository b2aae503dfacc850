"""What one simulated episode holds: frames, ground truth, and the verdicts on them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.detectors.scoring.score import DetectionScore
from magicsim.detectors.scoring.truth import FrameClass
from magicsim.detectors.verdict import Verdict
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import FrameState

Frame = npt.NDArray[np.uint8]
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class SolveFigures:
    """How trustworthy one frame's deformation is."""

    iterations: int
    """Newton iterations spent on this frame; 0 where nothing was solved."""
    min_jacobian: float
    """Smallest Jacobian at any Gauss point."""
    max_penetration_mm: float
    """Deepest contact point inside the object [mm]."""
    force_balance: float
    """Relative difference between contact force and reaction."""


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
    """Its torque about the origin [N mm]."""
    contact_area_mm2: float
    """Area under pressure [mm2]."""
    frame_class: FrameClass | None
    """Class for scoring, None where the frame is not scored."""
    solve: SolveFigures
    """Quality of the deformation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedFrame:
    """One frame of the stream with everything known about it."""

    image: Frame
    """RGB, shape (rows, columns, 3)."""
    truth: FrameTruth
    contact_mask: npt.NDArray[np.bool_] | None
    """Pixels whose ray meets the contact, shape (rows, columns); None where not asked for."""
    displacements_mm: npt.NDArray[np.float32] | None
    """Lattice displacements, shape (nodes, 3) [mm]; None where not asked for."""
    depth_map_mm: npt.NDArray[np.float32] | None = None
    """How far the contact face is pressed in at each pixel, shape (rows, columns) [mm]; None where not asked for."""
    markers_mm: npt.NDArray[np.float64] | None = None
    """Centres of the markers in the sensor's frame, displaced, shape (markers, 3) [mm]; None without markers."""
    markers_px: npt.NDArray[np.float64] | None = None
    """Where the camera sees them, column and row, whole at pixel centres, shape (markers, 2) [px]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """All frames of one scene, references first."""

    scene: SceneConfig
    frames: tuple[SimulatedFrame, ...]
    seconds: float = 0.0
    """Warm cost of all frames, without compilation and scene build [s]."""

    @property
    def references(self) -> tuple[SimulatedFrame, ...]:
        """Frames of the untouched sensor that the detectors learn from."""
        return tuple(frame for frame in self.frames if frame.truth.is_reference)

    @property
    def scored(self) -> tuple[SimulatedFrame, ...]:
        """The frames after the references."""
        return tuple(frame for frame in self.frames if not frame.truth.is_reference)


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """What the detectors with one profile say about an episode's frames after the references."""

    profile: str
    """Name of the profile."""
    thresholds: dict[str, float]
    """tau_e, tau_c, tau_g of the profile."""
    verdicts: tuple[Verdict, ...]
    """One per frame after the references, in order."""
    score: DetectionScore
    """Against ground truth."""
