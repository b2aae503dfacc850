"""Mitsuba and Dr.Jit with the variant set: import them from here, and the order of imports cannot go wrong.

Dr.Jit looks for libLLVM when it is first imported, so the right one must be named before that.
"""

from magicsim.scenes.variant import activate_variant

VARIANT = activate_variant()

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

__all__ = ["VARIANT", "dr", "mi"]
