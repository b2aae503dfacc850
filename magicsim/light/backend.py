"""Mitsuba and Dr.Jit with the variant set: import them from here, and the order of imports cannot go wrong.

They are untyped here: their stubs describe all variants at once. Dr.Jit looks for libLLVM when it is first imported,
so the right one must be named before that.
"""

from typing import Any

from magicsim.light.variant import activate_variant

VARIANT = activate_variant()

import drjit  # noqa: E402
import mitsuba  # noqa: E402

dr: Any = drjit
mi: Any = mitsuba

__all__ = ["VARIANT", "dr", "mi"]
