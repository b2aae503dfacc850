"""The unit of work: one design, filmed and measured in whatever process, as the bytes of its result."""

import time
from dataclasses import dataclass

from magicsim.sweep.designs import SweptDesign
from magicsim.sweep.sweep_file import SweepConfig

FROM_FILM = frozenset(
    {
        "force_1mm_n", "stiffness_n_per_mm", "sensitivity_per_mm", "sensitivity_per_n", "proximity_range_mm",
        "contact_auc", "contact_accuracy", "localisation_mm", "frame_seconds", "unknowns",
    }
)  # fmt: skip
"""Measures that need the film."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignTask:
    """One design and how it is judged."""

    design: SweptDesign
    sweep: SweepConfig


def judge_design(task: DesignTask) -> bytes:
    """Judges one design and returns its `DesignResult` as JSON."""
    from magicsim.light.records.untouched_store import shared_states
    from magicsim.sweep import parts
    from magicsim.sweep.designs import renderings_of, rows_of_renderings
    from magicsim.sweep.mechanics import hardness
    from magicsim.sweep.result import DesignResult, printability

    start = time.perf_counter()
    design, sweep = task.design, task.sweep
    wanted = frozenset(sweep.measures)
    block = parts.block_of(design.sensor.design)
    gathered = parts.Parts()
    if "printability" in wanted:
        gathered.measures["printability"] = printability(block)
    if wanted & FROM_FILM:
        gathered.add(parts.filmed(design.sensor, sweep, shared_states()))
    if wanted & set(parts.SPACING_MEASURES.values()):
        gathered.add(parts.textured(design.sensor, sweep, shared_states()))
    if "shore_a" in wanted:
        gathered.measures["shore_a"] = hardness(design.sensor.design, sweep.quality)
    return DesignResult(
        index=design.index, values=design.values, is_extra=design.is_extra, block=block,
        measures={name: gathered.measures[name] for name in sweep.measures if name in gathered.measures},
        curves=gathered.curves, pictures=gathered.pictures, profile=gathered.profile,
        room=", ".join(sweep.rooms) or design.sensor.rig.room,
        passes=design.sensor.rig.moving is not None,
        drawn=rows_of_renderings(renderings_of(design.sensor, sweep)),
        seconds=time.perf_counter() - start,
    ).to_json()  # fmt: skip
