"""Decides before work starts what a scene needs, and says why the rest is left out.

Which frames are solved and rendered is decided exactly: leaving out changes no frame, which tests hold by rendering
with and without. What is left out within a frame up to a bound (the coarse far field of the lattice, what hardly moved,
the light of touches that change little of it) states that bound; where the lattice does not resolve an object's edges,
the plan says so. What only an exposed image tells, that an object is
too far to be seen, is left to the renderer (`magicsim.light.reach`).
"""

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from magicsim.deform.quality import SOLVE_QUALITIES
from magicsim.geometry.design import FAR_FIELD_BOUND, ElastomerDesign, LatticeOptions
from magicsim.geometry.grid import CellGrid, node_spacing_mm, resolve_grid
from magicsim.geometry.objects.textured import CELLS_A_PERIOD, DotsObject, LinesObject
from magicsim.scenes.field_check import check_room
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, reference_states, timeline

UNTOUCHED_FRAME = -1
"""Number that stands for the untouched state of the reference frames."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FramePlan:
    """What one scored frame needs."""

    state: FrameState
    solve: bool
    """Whether contact is possible, so that a deformation is solved."""
    same_as: int | None
    """Earlier frame whose radiance it shares (`UNTOUCHED_FRAME` for the references), or None to render."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """One stage that is kept or left out, and why."""

    stage: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ScenePlan:
    """The work of one episode."""

    scene: SceneConfig
    """What happens."""
    references: tuple[FramePlan, ...]
    """Frames of the untouched sensor before the scored ones."""
    frames: tuple[FramePlan, ...]
    kept: tuple[Decision, ...]
    left_out: tuple[Decision, ...]

    @property
    def efforts(self) -> list[int]:
        """Relative cost of every frame of the stream, references first, in hundredths of a rendering; an estimate."""
        render = self.scene.render
        untouched = round(100 * render.anchor_samples / render.samples) + 200
        references = [untouched if number == 0 else 1 for number in range(len(self.references))]
        return references + [1 + 100 * (frame.same_as is None) + 80 * frame.solve for frame in self.frames]


def plan_scene(scene: SceneConfig, *, leave_out: bool = True) -> ScenePlan:
    """Plans an episode; `ConfigError` where the object would be outside of a near room."""
    if scene.rig.near_mm is not None:
        check_room(scene)
    grid, spacing_mm = resolve_grid(scene.design), node_spacing_mm(scene.design)
    states, untouched = timeline(scene), reference_states(scene)
    frames: list[FramePlan] = []
    seen = {UNTOUCHED: UNTOUCHED_FRAME} if leave_out else {}
    dented = False
    for index, state in enumerate(states):
        touching = state.can_touch or dented
        dented = scene.contact.keeps_dent and touching
        relaxing = touching and scene.contact.rate_dependent
        before = frames[-1] if touching and frames and states[index - 1] == state else None
        look = as_seen(scene.design, state) if leave_out else state
        earlier = seen.get(look) if not touching else None
        if before is not None and leave_out and not relaxing:  # paths in contact have a history
            earlier = before.same_as if before.same_as is not None else index - 1
        frames.append(FramePlan(state=state, solve=touching and earlier is None, same_as=earlier))
        if leave_out and earlier is None and not touching:
            seen[look] = index
    kept, left_out = _explain(scene, frames, grid, spacing_mm)
    if scene.design.cell_mm > 0 and any(frame.solve for frame in frames):
        for is_kept, decision in _failures(scene):
            (kept if is_kept else left_out).append(decision)
    if scene.rig.near_mm is not None and not scene.design.is_opaque:
        reason = f"its picture is {scene.rig.near_mm:g} mm away and seen from each place; no shadow falls on it"
        kept.append(Decision(stage="near room", reason=reason))
    kept += [Decision(stage="every frame in order", reason=f"rig.{why}") for why in scene.rig.camera.history]
    if scene.rig.camera.live is not None:
        kept.append(Decision(stage="untouched frame", reason="rig.camera.live: refused if it never settles there"))
    alike = [as_seen(scene.design, state) == UNTOUCHED for state in untouched]
    references = tuple(
        FramePlan(state=state, solve=False, same_as=UNTOUCHED_FRAME if is_alike else None)
        for state, is_alike in zip(untouched, alike, strict=True)
    )
    return ScenePlan(
        scene=scene, references=references, frames=tuple(frames), kept=tuple(kept), left_out=tuple(left_out)
    )


def as_seen(design: ElastomerDesign, state: FrameState) -> FrameState:
    """The state without what a coat hides: flashlight, facing finger, and an object that does not touch."""
    if not design.is_opaque:
        return state
    hidden = replace(state, flashlight=False, light_x_mm=0.0, facing_mm=None, passing_mm=None, companion=None)
    return hidden if state.can_touch else UNTOUCHED


def _explain(
    scene: SceneConfig, frames: list[FramePlan], grid: CellGrid | None, spacing_mm: float
) -> tuple[list[Decision], list[Decision]]:
    kept: list[Decision] = []
    left_out: list[Decision] = []
    total = len(frames)
    if grid is None:
        left_out.append(Decision(stage="grid", reason="cell_mm is 0"))
    else:
        counts, sizes = (" x ".join(f"{each:.3g}" for each in values) for values in (grid.counts, grid.cell_mm))
        kept.append(Decision(stage="grid", reason=f"{counts} cells of {sizes} mm, as they fit into the block"))

    def decide(stage: str, count: int, why: str, why_not: str) -> None:
        if count:
            kept.append(Decision(stage=stage, reason=f"{count} of {total} frames: {why}"))
        if count < total:
            left_out.append(Decision(stage=stage, reason=f"{total - count} of {total} frames: {why_not}"))

    reasons = Counter(_why_no_solve(frame) for frame in frames if not frame.solve)
    solved = sum(frame.solve for frame in frames)
    if solved:
        kept += [
            Decision(stage="deformation", reason=f"{solved} of {total} frames: the object can touch"),
            *_coat(scene)[0],
        ]
    lattice = SOLVE_QUALITIES[scene.contact.quality].of(scene.design).lattice
    if solved and lattice.growth > 1:
        bound = f"node spacings grow by {lattice.growth:g} there; {_force_bound(lattice)}"
        left_out.append(Decision(stage="fine lattice away from the contact", reason=bound))
    if solved:
        left_out += _rough_edges(scene, spacing_mm) + _rough_pattern(scene, spacing_mm) + _coat(scene)[1]
    if solved and scene.render.still_mm > 0:
        bound = f"displacements below {scene.render.still_mm:g} mm are not rendered, and none is off by more"
        left_out.append(Decision(stage="light through what hardly moved", reason=bound))
    if solved and scene.render.reuse_mm > 0:
        bound = f"they are those of the untouched block where nothing near them moved by {scene.render.reuse_mm:g} mm"
        left_out.append(Decision(stage="camera paths past what hardly moved", reason=bound))
    if solved and scene.render.light_change > 0 and not scene.design.is_opaque:
        bound = (
            f"light of just before contact, where a touch is expected to change it by less than "
            f"{100 * scene.render.light_change:g} % (root mean square over the grid)"
        )
        left_out.append(Decision(stage="light pass of touches", reason=bound))
    left_out += [
        Decision(stage="deformation", reason=f"{count} of {total} frames: {reason}")
        for reason, count in reasons.items()
    ]
    rendered = sum(frame.same_as is None for frame in frames)
    decide("mesh and BVH update", rendered, "something moved", "nothing moved since an earlier frame that is reused")
    lightened = sum(
        frame.same_as is None and (scene.design.scatters or (frame.state.has_object and not scene.design.is_opaque))
        for frame in frames
    )
    why_not = "same pose and light as an earlier frame"
    decide("light pass", lightened, "the light changes", why_not if lightened == rendered else "nothing scatters")
    left_out += _behind_coat(scene)
    decide("camera pass", rendered, "the image changes", "same pose and light as an earlier frame")
    _explain_tier(scene, kept, left_out)
    for name, there, why, why_not in () if scene.design.is_opaque else _outside(frames):
        decide(f"{name} in the optical scene", there, why, why_not)
    references = f"{scene.references} frames: one untouched state, each frame with noise of its own"
    if scene.rig.moving is not None and not scene.design.is_opaque:
        references = f"{scene.references} frames of the untouched sensor: something passes in the room"
    if scene.references:
        kept.append(Decision(stage="reference frames", reason=references))
    for name in type(scene.output).model_fields:
        asked = getattr(scene.output, name)
        reason = "asked for" if asked else "not asked for (output settings)"
        (kept if asked else left_out).append(Decision(stage=f"output {name}", reason=reason))
    return kept, left_out


def _explain_tier(scene: SceneConfig, kept: list[Decision], left_out: list[Decision]) -> None:
    """What the fast tier leaves out, or why it does not."""
    if scene.render.tier == "true":
        return
    from magicsim.emulator.emulator import known_model
    from magicsim.emulator.model import ALL

    model = known_model(scene.design, scene.rig, scene.object, scene.contact, scene.render)
    stage, beyond = "both passes, of touches and of what is near", "rendered"
    if scene.render.outside_domain == "refuse":
        beyond = "refused (render.outside_domain)"
    if isinstance(model, str):
        kept.append(Decision(stage=stage, reason=f"{beyond}: {model}"))
        return
    off = "".join(f", {row.error:.2g} grey levels off" for row in model.facts.errors if row.states == ALL)
    known = f"touches by the model '{model.facts.name}'{off}; what it does not know is {beyond}"
    left_out.append(Decision(stage=stage, reason=known))


def _outside(frames: list[FramePlan]) -> Iterator[tuple[str, int, str, str]]:
    """What stands outside, in how many frames, and why it is in the optical scene or not."""
    yield "object", sum(frame.state.has_object for frame in frames), "the object is there", "no object"
    yield "flashlight", sum(frame.state.flashlight for frame in frames), "the light is on", "the light is off"


def _behind_coat(scene: SceneConfig) -> list[Decision]:
    reason = "design.coat is opaque: what is outside is not seen, only what it does to the face"
    stage = "object, flashlight and room in the optical scene"
    return [Decision(stage=stage, reason=reason)] if scene.design.is_opaque else []


def _failures(scene: SceneConfig) -> Iterator[tuple[bool, Decision]]:
    """Whether the infill flows and walls buckle and tear, and why."""
    for name, stage, never, does in (
        ("infill_yield_mpa", "flow of the infill", "the infill is elastic at any load",
         "from {:g} MPa on, by steps of a tenth of a millimetre"),
        ("wall_buckling_strain", "buckling of walls", "walls carry more up to a squeeze of 0.35",
         "walls carry no more from a squeeze of {:g} on"),
        ("wall_tear_elongation", "tearing of walls", "walls stretch without end",
         "a touch that stretches walls by {:g} is refused, by steps of a tenth of a millimetre"),
    ):  # fmt: skip
        value = getattr(scene.contact, name)
        reason = f"contact.{name} is not set: {never}" if value is None else does.format(value)
        yield value is not None, Decision(stage=stage, reason=reason)


def _coat(scene: SceneConfig) -> tuple[list[Decision], list[Decision]]:
    """What a coat with thickness and modulus adds to the deformation, and what it would do besides."""
    coat = scene.design.coat
    if coat is None or coat.shear_n_per_mm == 0:
        return [], []
    felt = f"it resists stretch with {3 * coat.shear_n_per_mm:.3g} N/mm, its modulus times its thickness"
    wrinkle = coat.wrinkle_mm(scene.design.materials.body.youngs_modulus_mpa)
    bends = f"it counts where the face bends over {wrinkle:.2g} mm or less; contacts should be some times as wide"
    return [Decision(stage="coat as a membrane", reason=felt)], [Decision(stage="bending of the coat", reason=bends)]


def _why_no_solve(frame: FramePlan) -> str:
    if not frame.state.has_object:
        return "no object"
    return "the object cannot touch" if not frame.state.can_touch else "same pose as the frame before"


def _rough_edges(scene: SceneConfig, spacing_mm: float) -> list[Decision]:
    """What a lattice coarser than the object's edges leaves out, where it is not made finer there."""
    edge, options = getattr(scene.object, "edge_radius_mm", None) or math.inf, scene.design.lattice
    if edge >= spacing_mm or (options.edge_nodes > 0 and options.cells_across > 0):
        return []
    reason = (
        f"edges of {edge:.3g} mm on cells of up to {spacing_mm:.3g} mm: where they touch, and on the flat faces "
        "between them, area, mask and picture of the contact are rough; design.lattice.edge_nodes and spacing_mm refine"
    )
    return [Decision(stage="lattice as fine as the object's edges", reason=reason)]


def _rough_pattern(scene: SceneConfig, spacing_mm: float) -> list[Decision]:
    """What a lattice leaves out of dots or lines that it does not resolve."""
    pattern = scene.object
    if not isinstance(pattern, DotsObject | LinesObject) or pattern.spacing_mm >= CELLS_A_PERIOD * spacing_mm:
        return []
    reason = (
        f"{pattern.kind} {pattern.spacing_mm:g} mm apart on cells of up to {spacing_mm:.3g} mm press as their "
        "mean does, with forces up to a fifth off, and hardly show one by one; "
        f"design.lattice.spacing_mm = {pattern.spacing_mm / CELLS_A_PERIOD:.3g} resolves them"
    )
    return [Decision(stage="lattice as fine as the object's pattern", reason=reason)]


def _force_bound(lattice: LatticeOptions) -> str:
    usual = LatticeOptions()
    is_bounded = (
        lattice.growth <= usual.growth and lattice.margin >= usual.margin and lattice.fine_depth >= usual.fine_depth
    )
    if is_bounded:
        return f"forces within {FAR_FIELD_BOUND:.0%} of the whole lattice's"
    return "steeper than by default, for which alone a bound of the forces is known"
