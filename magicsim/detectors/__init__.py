"""Published proximity and contact detection of the MagicGripper, for simulated and real frames alike.

Needs only NumPy and OpenCV, so that it runs unchanged beside a real sensor.
"""

from magicsim.detectors.calibrate import Calibration, Candidates, CandidateScore, fit_profile
from magicsim.detectors.combined import detect, detect_all, detect_stream
from magicsim.detectors.features import Episode
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import BackgroundReference, GridReference
from magicsim.detectors.grasp import GraspStage, GraspState, SlipState, step_grasp, step_slip
from magicsim.detectors.offline import detect_sources, stream_sources
from magicsim.detectors.picture import read_image
from magicsim.detectors.profile import DetectorProfile, load_profile, profile_schema, save_profile
from magicsim.detectors.rest import References, Rest, fuse, with_touches
from magicsim.detectors.source import SourceFrame, read_source
from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.frame_class import FrameClass, classify_frame
from magicsim.names import lazy_names

__all__ = [
    "BackgroundReference", "Calibration", "CandidateScore", "Candidates", "Contact", "DetectionScore",
    "DetectorProfile", "Episode", "Frame", "FrameClass", "GraspStage", "GraspState", "GridReference", "Proximity",
    "References", "Rest", "SlipState", "SourceFrame", "TaskScore", "Verdict", "check_frame",
    "classify_frame", "detect", "detect_all", "detect_sources", "detect_stream", "fit_profile",
    "fuse", "load_profile", "profile_schema", "read_image", "read_source", "save_profile",
    "score_verdicts", "step_grasp", "step_slip", "stream_sources", "with_touches",
]  # fmt: skip
__getattr__, __dir__ = lazy_names(  # judge stands above this package and needs no more than it
    __name__, dict.fromkeys(("DetectionScore", "TaskScore", "score_verdicts"), "magicsim.judge.score")
)
