"""What materials have in common whose light leaves in single directions alone, for Mitsuba's own integrators."""

from typing import Any

from magicsim.light.backend import mi


class SingleDirections(mi.BSDF):  # type: ignore[misc]
    """Reflects (component 0) and transmits (component 1) into directions whose density nobody asks for."""

    def __init__(self, properties: Any) -> None:
        """Declares both components, on both sides."""
        super().__init__(properties)
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [mi.BSDFFlags.DeltaReflection | both, mi.BSDFFlags.DeltaTransmission | both]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        """Nothing but single directions."""
        del context, si, wo, active
        return mi.Color3f(0)

    def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        """Nothing but single directions."""
        del context, si, wo, active
        return mi.Float(0)

    def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        """Nothing but single directions."""
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)
