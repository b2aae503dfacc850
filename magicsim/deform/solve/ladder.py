"""What is tried where an equilibrium is not found in the ordinary way: every rung of the ladder, and where it stands.

| level | what fails | what is tried, in this order | where |
| --- | --- | --- | --- |
| iteration | the model of the body is a poor one | a factor at the present state | `condensed` |
| iteration | the matrix is not definite | `SHIFTED` | `condensed`, `newton` |
| iteration | the condensed step, for one of `WHY_PLAIN` | `PLAIN` | `newton` |
| iteration | the step folds a cell, or the energy rises | a shorter one; `STRETCHED` after a shift | `line_search` |
| load step | no equilibrium | `HALVED` and `CAREFUL`, then `PATIENT` | `strides`, `Problem` |
| load step | no short one leads on | `LEAP` | `strides` |
| path | no load step leads on | `FEWER` | `path` |

A result names the rungs on which it stands (`Deformation.rungs`), and for plain steps why they were taken, so that
`magicsim bench stress` counts what each one of them is good for.
"""

from enum import StrEnum


class Rung(StrEnum):
    """A way other than the ordinary one."""

    SHIFTED = "shifted"
    """A multiple of the spring Laplacian was added to the matrix."""
    PLAIN = "plain"
    """A Newton step of body and contact together, the contact not solved in full; why is one of `WHY_PLAIN`."""
    UNTOUCHED = "untouched"
    """Plain: no facet of the face is near the object."""
    LARGE = "large"
    """Plain: the part of the face near the object is too large for a dense matrix."""
    INDEFINITE = "indefinite"
    """Plain: no shift makes the body's matrix definite."""
    UNSOLVED = "unsolved"
    """Plain: the contact problem of the face, solved by itself, has no solution."""
    STRETCHED = "stretched"
    """A step of a matrix that is stiffer than the Hessian, doubled while the energy decreased."""
    HALVED = "halved"
    """A shorter load step."""
    CAREFUL = "careful"
    """More iterations, each of them with a new factor; friction limits wait for balance."""
    PATIENT = "patient"
    """Plain steps only, because they were asked for, and many of them."""
    LEAP = "leap"
    """A longer load step, over the snap of a face that no short one can follow."""
    FEWER = "fewer"
    """The path begun again from rest with longer load steps."""


WHY_PLAIN = frozenset({Rung.UNTOUCHED, Rung.LARGE, Rung.INDEFINITE, Rung.UNSOLVED, Rung.PATIENT})
"""Reasons for a plain step: what a condensed one says instead of a result."""


def named(rungs: frozenset[Rung]) -> tuple[str, ...]:
    """Their names in the order of the ladder."""
    return tuple(rung.value for rung in Rung if rung in rungs)
