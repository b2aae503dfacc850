"""What the renderings of a design may not differ by."""

from magicsim.dataset.recipes.recipe import CameraNoise, Tolerances

SHAPES = (
    "skin_mm", "wall_mm", "wall_spread_mm", "wave_mm", "skin_spread_mm", "pitch_scale", "pitch_drift", "torn_share",
    "stiffness",
)  # fmt: skip
"""Tolerances that change meshes or forces, which the renderings of a design share."""
TIMED = ("exposure_ms", "flicker_depth", "led_drift_share", "live_frames")
"""What a camera does in the course of a stream; frames of a film have no times."""


def problem_with(tolerances: Tolerances, camera: CameraNoise) -> str | None:
    """Why renderings cannot differ by this, in one line; None where they can."""
    for table, given, usual, names, why in (
        ("tolerances", tolerances, Tolerances(), SHAPES, "renderings of a design share its meshes and presses"),
        ("camera", camera, CameraNoise(), TIMED, "frames of a film have no times"),
    ):
        for name in names:
            if getattr(given, name) != getattr(usual, name):
                allowed = [each for each in type(given).model_fields if each not in names]
                return f"{table}.{name} is not allowed in a sweep, as {why}: must be among {', '.join(allowed)}"
    return None
