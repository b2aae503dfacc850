"""Fits `detectors/calibrated.toml` on simulated episodes of other objects and other seeds than the demo's.

    python detectors/calibrate.py              # eight minutes on two cores, beside other work

The episodes run the demo's story with a box, a cylinder, a small dark ball, a flat punch, a ball of an orange's size
and a thick light cylinder, off centre, with seeds of their own, before several sensors: in an office, in the dark on a
print with thicker walls, beside a window behind a noisier camera and behind a quiet one, in a brighter office. Options
are chosen among `CANDIDATES`; thresholds are fitted exactly and keep four standard deviations from each of these
sensors at rest (`magicsim.detectors.calibrate`).
"""

import argparse
import logging
from pathlib import Path

from magicsim.detectors.calibrate import Calibration, Candidates, fit_profile
from magicsim.detectors.features import Episode as LabelledEpisode
from magicsim.detectors.profile import load_profile, save_profile
from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.episode import Episode
from magicsim.simulation.stream import simulate

DIM, BRIGHT = "rig.ambient=[0.03,0.03,0.03]", "rig.ambient=[0.2,0.2,0.2]"
WEBCAM = ("rig.camera.full_well_e=40000", "rig.camera.read_noise_e=60", "rig.camera.vibration_px=0.02")
TRAINING = (
    # object, seed, offset along x and y [mm], depth in units of the demo's, sensor
    ("box:size_mm=7x7x10,edge_radius_mm=0.5,color=0.75x0.75x0.7", 101, (-2.0, 3.0), 0.7, ()),
    ("cylinder:radius_mm=3,length_mm=14,axis=y,edge_radius_mm=0.5,color=0.2x0.6x0.25", 102, (2.5, -2.0), 0.8,
     ("rig.room='dark'", "design.wall_mm=0.12", "design.cell_mm=0.78")),
    ("sphere:radius_mm=3,color=0.25x0.25x0.3", 103, (3.0, 4.0), 1.0, ("rig.room='window'", DIM, *WEBCAM)),
    ("punch:radius_mm=3,edge_radius_mm=0.5,color=0.6x0.15x0.1", 104, (-3.0, -5.0), 0.7, (BRIGHT,)),
    ("sphere:radius_mm=25,color=0.6x0.35x0.25", 105, (1.0, -1.0), 0.3, ()),
    ("cylinder:radius_mm=8,length_mm=24,axis=x,edge_radius_mm=0.5,color=0.8x0.75x0.6", 106, (0.0, 2.0), 0.4,
     ("rig.room='window'",)),
)  # fmt: skip
CANDIDATES = Candidates(
    tau_b=(15, 25, 35, 45, 60, 90, 95, 100, 105),
    polarity=("dark", "bright"),
    similarity=("recall", "iou"),
    grid_blur_px=(3, 5),
    difference_blur_px=(0, 5),
    surround_px=(0, 4, 6),
)
COMMENT = """Fitted by detectors/calibrate.py on six simulated episodes of mini-magictac with the lights and lens of
digit-office (a box, two cylinders, a small dark ball, a flat punch, a ball of an orange's size; seeds 101 to 106): in
offices of two brightnesses, in the dark on a print with thicker walls, beside a window behind a noisier camera and
behind a quiet one. Fit again for another design or rig."""


def training_scene(
    text: str, seed: int, offset_mm: tuple[float, float], depth: float, sensor: tuple[str, ...]
) -> SceneConfig:
    """The demo's story with another object, elsewhere, pressed to a share of its depth, and without friction."""
    demo = load_scene("demo", ["contact.friction=0", *sensor], seed=seed)
    keyframes = []
    for keyframe in demo.keyframes:
        changes = {}
        if keyframe.gap_mm is not None:
            gap = keyframe.gap_mm * depth if keyframe.gap_mm < 0 else keyframe.gap_mm
            changes = {"gap_mm": gap, "x_mm": keyframe.x_mm + offset_mm[0], "y_mm": keyframe.y_mm + offset_mm[1]}
        keyframes.append(keyframe.model_copy(update=changes))
    return demo.model_copy(update={"object": parse_object(text), "keyframes": tuple(keyframes)})


def labelled(episode: Episode) -> LabelledEpisode:
    """What the fit needs of an episode."""
    return LabelledEpisode(
        references=[frame.image for frame in episode.references],
        frames=[frame.image for frame in episode.scored],
        classes=[frame.truth.frame_class for frame in episode.scored],
    )


def describe(calibration: Calibration) -> str:
    """The candidates, best first, one line each."""
    columns = "tau_b polarity similarity grid_blur difference_blur  tau_e  tau_c  tau_g"
    lines = [f"proximity contact margins      {columns}"]
    for score in sorted(calibration.candidates, key=lambda each: -(each.accuracy or 0))[:12]:
        one, contact, margin = score.profile, score.contact_accuracy or 0, score.contact_margin or 0
        lines.append(
            f"{score.proximity_accuracy:9.3f} {contact:7.3f} {score.proximity_margin:6.2f} {margin:6.2f} "
            f"{one.tau_b:6d} {one.polarity:8s} {one.similarity:10s} {one.grid_blur_px:9d} {one.difference_blur_px:15d} "
            f"{one.tau_e:6.2f} {one.tau_c:6.3f} {one.tau_g:6.3f}"
        )
    return "\n".join(lines)


def main() -> None:
    """Simulates the training episodes, fits, writes the profile and reports every candidate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name("calibrated.toml"))
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    episodes = []
    for each in TRAINING:
        logging.info("simulating %s", each[0])
        episodes.append(labelled(simulate(training_scene(*each))))
    calibration = fit_profile(load_profile("published"), episodes, CANDIDATES)
    logging.info("%s", describe(calibration))
    save_profile(calibration.profile, arguments.out, comment=COMMENT)
    logging.info("wrote %s", arguments.out.name)


if __name__ == "__main__":
    main()
