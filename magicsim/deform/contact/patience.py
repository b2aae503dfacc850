"""When multipliers of contact and limits of friction follow the pressures that they led to."""

from dataclasses import dataclass, replace

from magicsim.deform.contact.augmented import ContactState
from magicsim.deform.contact.friction import ContactLaw, ContactMemory, updated_limits


@dataclass(frozen=True, slots=True, kw_only=True)
class Patience:
    """When to update what; far from balance pressures mean nothing."""

    misfit_mm: float
    """Largest penetration, and largest gap under pressure, that needs no update [mm]."""
    mismatch: float
    """Largest departure from the law of friction that needs none, see `contact.augmented.slip_mismatch`."""
    multiplier_residual: float
    """Relative residual below which multipliers are updated."""
    limit_residual: float
    """Relative residual below which limits of friction are updated."""
    is_relaxed: bool
    """Whether limits go only part of the way."""
    updates: int
    """Most updates of the multipliers, after which the penalty is raised instead."""
    growth: float
    """Factor of the penalty then."""
    reprieve: int = 0
    """Updates of multipliers that a raised penalty is given before it is raised again."""
    largest_misfit_mm: float = 0.0
    """Up to this the penalty is never raised [mm]."""


def updated_memory(
    patience: Patience, law: ContactLaw, memory: ContactMemory, contact: ContactState, residual: float, mismatch: float
) -> ContactMemory:
    """The memory with what is due brought up to date; the same object where nothing is.

    Args:
        patience: What is due.
        law: Coefficient of friction.
        memory: As it is.
        contact: What it led to.
        residual: Relative norm of the out-of-balance forces.
        mismatch: Of the friction limits.
    """
    if mismatch > patience.mismatch and residual < patience.limit_residual:
        memory = updated_limits(memory, contact.pressure_mpa, contact.normal, law, patient=patience.is_relaxed)
    if residual >= patience.multiplier_residual or contact.misfit_mm <= patience.misfit_mm:
        return memory
    if memory.updates < patience.updates:
        return replace(memory, multipliers_mpa=contact.pressure_mpa, updates=memory.updates + 1)
    if contact.misfit_mm <= patience.largest_misfit_mm:
        return memory
    updates = patience.updates - patience.reprieve
    return replace(memory, penalty=patience.growth * memory.penalty, updates=updates)
