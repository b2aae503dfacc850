"""Published proximity and contact detection of the MagicGripper, for simulated and real frames alike.

Needs only NumPy and OpenCV, so that it runs unchanged beside a real sensor.
"""

from magicsim.detectors.combined import detect, detect_all, detect_stream
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import BackgroundReference, References, fuse
from magicsim.detectors.grasp import GraspStage, GraspState, run_grasp, step_grasp
from magicsim.detectors.grid import GridReference
from magicsim.detectors.offline import detect_sources, stream_sources
from magicsim.detectors.profiles.calibrate import Calibration, Candidates, CandidateScore, fit_profile
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile, save_profile
from magicsim.detectors.profiles.profile_schema import profile_schema
from magicsim.detectors.scoring.episode import Episode
from magicsim.detectors.scoring.score import DetectionScore, TaskScore, score_verdicts
from magicsim.detectors.slip import SlipState, step_slip
from magicsim.detectors.sources.source import SourceFrame, read_image, read_source
from magicsim.detectors.stream import StreamState, detect_from_start, start_stream, step_stream
from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.frame_class import FrameClass, classify_frame

__all__ = [
    "BackgroundReference",
    "Calibration",
    "CandidateScore",
    "Candidates",
    "Contact",
    "DetectionScore",
    "DetectorProfile",
    "Episode",
    "Frame",
    "FrameClass",
    "GraspStage",
    "GraspState",
    "GridReference",
    "Proximity",
    "References",
    "SlipState",
    "SourceFrame",
    "StreamState",
    "TaskScore",
    "Verdict",
    "check_frame",
    "classify_frame",
    "detect",
    "detect_all",
    "detect_from_start",
    "detect_sources",
    "detect_stream",
    "fit_profile",
    "fuse",
    "load_profile",
    "profile_schema",
    "read_image",
    "read_source",
    "run_grasp",
    "save_profile",
    "score_verdicts",
    "start_stream",
    "step_grasp",
    "step_slip",
    "step_stream",
    "stream_sources",
]
