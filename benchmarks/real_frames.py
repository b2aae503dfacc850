"""Fits a translucent sensor to one real press and predicts two others: `docs/real-frames.json` and its pictures.

    python benchmarks/real_frames.py             # all stages
    python benchmarks/real_frames.py fit         # fits again to the renderings of docs/real-frames/renders.json
    python benchmarks/real_frames.py confirm     # whole frames with the constants of the last fit: curves, SSIM, PSNR

The frames in `docs/real-frames` are 9DTact's (MIT). Fitted: scattering, absorption, the coat's reflectance, the radius
of the ring of light and the depth of the press, and of the camera vignetting, exposure and gamma (or none), one set for
the untouched frame and the pressed one, on mean levels of rings about the middle of the contact. `render` makes both
frames at places of a Latin hypercube over the constants and at four depths; `fit` smooths the logarithms of their
rings with polynomials, which takes the noise of single renderings out of it, solves for the constants, and does so
again with polynomials that go through a careful rendering of what was found. `confirm` renders anew: all curves,
residuals and comparisons are of these renderings, whose exposure is metered on the untouched frame. `predict` renders
two thirds of that depth and a layer thinner by a tenth; nothing is compared with that.
"""

import argparse
import json
from dataclasses import replace
from typing import Any

import numpy as np
from laboratory.real_frames.comparison import confirm
from laboratory.real_frames.constants import Constants
from laboratory.real_frames.fitting import fitted
from laboratory.real_frames.frames import FOLDER
from laboratory.real_frames.pictures import plot
from laboratory.real_frames.prediction import THINNER, predict
from laboratory.real_frames.renderings import POINTS, render

from magicsim.light.variant import activate_variant

RENDERS, RESULT = FOLDER / "renders.json", FOLDER.parent / "real-frames.json"


def main() -> None:
    """Runs the stages."""
    stages = ("render", "fit", "confirm", "predict")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stages", nargs="*", help=f"of {', '.join(stages)}; all without")
    asked = parser.parse_args().stages or stages
    if not set(asked) <= set(stages):
        parser.error(f"unknown stage; there are {', '.join(stages)}")
    activate_variant()
    if "render" in asked:
        RENDERS.write_text(json.dumps(render(range(POINTS))) + "\n", encoding="utf-8")
    told: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8")) if RESULT.exists() else {}
    if "fit" in asked:
        told = fitted(np.array(json.loads(RENDERS.read_text(encoding="utf-8"))))
    constants = Constants(**{name: each["value"] for name, each in told["constants"].items()})
    if "confirm" in asked:
        told |= confirm(constants)
        told["constants"]["exposure"]["value"] = told["exposure"]
        constants = replace(constants, exposure=told["exposure"])
    if "predict" in asked:
        covariance = np.array(told["covariance"])
        told["predictions"] = {
            "two thirds of the depth": predict(constants, covariance, 2 / 3),
            "layer thinner by a tenth": predict(constants, covariance, 1.0, THINNER),
        }
    RESULT.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    plot(told)


if __name__ == "__main__":
    main()
