"""Solids of everyday things, as pure functions of a few dimensions: spanner head, handle, scissors' loops, banana.

Each is closed and outward, its edges rounded where skin would touch them. Only the part near the sensor is modelled.
"""

from itertools import pairwise

import numpy as np
from manifold3d import CrossSection, JoinType, Manifold, OpType

from magicsim.arrays import Array

CIRCLE = 96
"""Segments of the large circles of a section."""
BALL = 24
"""Segments of the balls that round edges and sweep tubes."""


def spanner_head(
    jaw_mm: float, head_radius_mm: float, handle_width_mm: float, thickness_mm: float, edge_radius_mm: float
) -> Manifold:
    """The open end of a spanner, flat in the xy plane, its jaw towards +y and turned by 15 degrees.

    Args:
        jaw_mm: Width across flats [mm].
        head_radius_mm: Of the round head [mm].
        handle_width_mm: Of the handle, which leaves the head towards -y [mm].
        thickness_mm: Along z [mm].
        edge_radius_mm: Of all outer edges [mm].
    """
    length = 2.5 * head_radius_mm
    slot = CrossSection.square((jaw_mm, 2 * head_radius_mm), center=True).translate((0, 0.6 * head_radius_mm))
    handle = CrossSection.square((handle_width_mm, length), center=True).translate((0, -length / 2))
    outline = CrossSection.circle(head_radius_mm, CIRCLE) - slot.rotate(15) + handle
    core = outline.offset(-edge_radius_mm, JoinType.Miter).simplify(0.02)
    flat = Manifold.extrude(core, thickness_mm - 2 * edge_radius_mm)
    flat = flat.translate((0, 0, edge_radius_mm - thickness_mm / 2))
    return flat.minkowski_sum(Manifold.sphere(edge_radius_mm, 12))


def fluted_handle(radius_mm: float, length_mm: float, flutes: int) -> Manifold:
    """A screwdriver's handle along y with lengthwise flutes, its butt at +y a dome.

    Args:
        radius_mm: Over the ridges between the flutes [mm].
        length_mm: From the butt to the end that is cut off [mm].
        flutes: Number of grooves.
    """
    groove = CrossSection.circle(0.55 * radius_mm, CIRCLE // 2).translate((1.42 * radius_mm, 0))
    section = CrossSection.circle(radius_mm, CIRCLE)
    for number in range(flutes):
        section -= groove.rotate(360 * (number + 0.5) / flutes)
    rounding = 0.08 * radius_mm
    section = section.offset(-rounding, circular_segments=BALL).offset(rounding, circular_segments=2 * BALL)
    body = Manifold.extrude(section.simplify(0.005), length_mm)
    half = np.linspace(0, np.pi / 2, CIRCLE // 4 + 1)
    dome = np.stack([radius_mm * np.cos(half), length_mm - 0.6 * radius_mm * (1 - np.sin(half))], axis=1)
    outline = np.concatenate([[[0.0, 0.0], [radius_mm, 0.0]], dome[:-1], [[0.0, length_mm]]])
    handle = body ^ Manifold.revolve(CrossSection([outline]), CIRCLE)
    return handle.translate((0, 0, -length_mm / 2)).rotate((-90, 0, 0))


def tube(centres_mm: Array, radii_mm: Array) -> Manifold:
    """Hulls of neighbouring balls along a polyline, united.

    Args:
        centres_mm: Shape (points, 3) [mm].
        radii_mm: Shape (points,) [mm].
    """
    balls = [
        Manifold.sphere(float(radius), BALL).translate(tuple(centre))
        for centre, radius in zip(centres_mm, radii_mm, strict=True)
    ]
    pieces = [Manifold.batch_hull([one, other]) for one, other in pairwise(balls)]
    return Manifold.batch_boolean(pieces, OpType.Add)


def scissor_loops(loop_width_mm: float, loop_length_mm: float, tube_radius_mm: float, gap_mm: float) -> Manifold:
    """The two finger loops of scissors side by side in the xy plane, their arms running together towards +y.

    Args:
        loop_width_mm: Of one loop's centre line, along x [mm].
        loop_length_mm: Of one loop's centre line, along y [mm].
        tube_radius_mm: Of the round stock that the loops are bent from [mm].
        gap_mm: Free distance between the loops, where they are closest [mm].
    """
    turn = np.linspace(0, 2 * np.pi, 49)
    offset = (loop_width_mm + gap_mm) / 2 + tube_radius_mm
    loop = np.stack([loop_width_mm / 2 * np.cos(turn), loop_length_mm / 2 * np.sin(turn), 0 * turn], axis=1)
    parts = []
    for side in (-1.0, 1.0):
        centre = np.array([side * offset, 0.0, 0.0])
        end = centre + np.array([0.0, loop_length_mm / 2, 0.0])
        arm = np.stack([end, np.array([side * tube_radius_mm, loop_length_mm, 0.0])])
        parts += [
            tube(loop + centre, np.full(len(loop), tube_radius_mm)),
            tube(arm, np.full(len(arm), tube_radius_mm)),
        ]
    return Manifold.batch_boolean(parts, OpType.Add)


def banana_section(radius_mm: float, length_mm: float, bend_radius_mm: float) -> Manifold:
    """The middle of a banana along y: a bent five-sided bar with rounded ridges, its outer side towards +z.

    Args:
        radius_mm: Of the circle around its section in the middle [mm]; a quarter less at both ends.
        length_mm: Along the bend [mm].
        bend_radius_mm: Of the centre line [mm].
    """
    along = np.linspace(-1, 1, 13)
    angles = along * length_mm / 2 / bend_radius_mm
    sections = []
    for place, angle in zip(along, angles, strict=True):
        around = radius_mm * (1 - 0.25 * place**2)
        ridge = 0.4 * around
        ball = Manifold.sphere(ridge, BALL)
        spokes = np.radians(90 + 36 + 72 * np.arange(5))
        corners = [
            ball.translate(((around - ridge) * np.cos(spoke), 0.0, (around - ridge) * np.sin(spoke)))
            for spoke in spokes
        ]
        flat = Manifold.batch_hull(corners)
        lifted = flat.translate((0, 0, bend_radius_mm)).rotate((float(-np.degrees(angle)), 0, 0))
        sections.append(lifted.translate((0, 0, -bend_radius_mm)))
    pieces = [Manifold.batch_hull([one, other]) for one, other in pairwise(sections)]
    return Manifold.batch_boolean(pieces, OpType.Add)
