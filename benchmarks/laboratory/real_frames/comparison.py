"""Rendered frames beside the real ones: curves, what is left over, whole frames."""

from dataclasses import replace
from typing import Any

import numpy as np
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from laboratory.real_frames.constants import Constants
from laboratory.real_frames.frames import MIDDLES_MM, features, grey, observed, profile, shade
from laboratory.real_frames.pictures import draw_pairs
from laboratory.real_frames.renderings import SHOWN, radiance

MIDDLE_GREY = 128.0
"""What no change is, where the change by the press is compared as an image."""


def confirm(constants: Constants) -> dict[str, Any]:
    """Curves, what is left over, comparisons of whole frames, pictures; exposure is metered on the untouched one."""
    real = np.array([observed("ref"), observed("sample")])
    found, shading = radiance(constants, *SHOWN), shade(constants.vignetting)
    level = profile(real[0]).mean() / profile(grey(found[0], constants, shading)).mean()
    constants = replace(constants, exposure=constants.exposure + constants.gamma * float(np.log(level)))
    seen = grey(found, constants, shading)
    rings = {name: np.array([profile(each) for each in pair]) for name, pair in (("real", real), ("seen", seen))}
    drops = {name: each[0] - each[1] for name, each in rings.items()}
    pairs = dict(zip(("untouched", "pressed"), zip(real, seen, strict=True), strict=True))
    pairs["change"] = (real[1] - real[0] + MIDDLE_GREY, seen[1] - seen[0] + MIDDLE_GREY)
    draw_pairs(pairs)
    return {
        "exposure": constants.exposure,
        "rms_profiles_grey": float(np.sqrt(np.mean((rings["seen"] - rings["real"]) ** 2))),
        "rms_change_profile_grey": float(np.sqrt(np.mean((drops["seen"] - drops["real"]) ** 2))),
        "rms_blocks_grey": float(np.sqrt(np.mean((seen - real) ** 2))),
        "features_observed": features(drops["real"]),
        "features_fitted": features(drops["seen"]),
        "radius_mm": MIDDLES_MM.tolist(),
        "curves": {
            "observed": drops["real"].round(2).tolist(), "fitted": drops["seen"].round(2).tolist(),
            "untouched, observed": rings["real"][0].round(2).tolist(),
            "untouched, fitted": rings["seen"][0].round(2).tolist(),
        },
        "whole_frames": {
            name: {
                "ssim": float(structural_similarity(one, other, data_range=255)),  # type: ignore[no-untyped-call]
                "psnr_db": float(peak_signal_noise_ratio(one, other, data_range=255)),  # type: ignore[no-untyped-call]
            }
            for name, (one, other) in pairs.items()
        },
    }  # fmt: skip
