"""When multipliers of contact and limits of friction follow the pressures that they led to."""

from dataclasses import replace

from magicsim.deform.contact import ContactState
from magicsim.deform.friction import ContactLaw, ContactMemory, updated_limits
from magicsim.deform.problem import NewtonOptions


def updated_memory(
    options: NewtonOptions,
    law: ContactLaw,
    memory: ContactMemory,
    contact: ContactState,
    residual: float,
    mismatch: float,
    iteration: int,
) -> ContactMemory:
    """The memory with what is due brought up to date; the same object where nothing is.

    Args:
        options: Tolerances.
        law: Coefficient of friction.
        memory: As it is.
        contact: What it led to.
        residual: Relative norm of the out-of-balance forces; far from balance pressures mean nothing.
        mismatch: Of the friction limits, see `contact.slip_mismatch`.
        iteration: After `NewtonOptions.patience` of them limits are updated in balance only, and in part.
    """
    patient = iteration >= options.patience
    if mismatch > options.slip_mismatch and residual < options.limit_residual[patient]:
        memory = updated_limits(memory, contact.pressure_mpa, contact.normal, law, patient=patient)
    if residual < options.update_residual and contact.misfit_mm > options.tolerance_mm:
        if memory.updates < options.multiplier_updates:
            memory = replace(memory, multipliers_mpa=contact.pressure_mpa, updates=memory.updates + 1)
        else:
            memory = replace(memory, penalty=options.penalty_growth * memory.penalty)
    return memory
