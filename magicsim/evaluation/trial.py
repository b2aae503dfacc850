"""Does a detector keep to its rules? It leaves the references as they are, and what it says follows from frames so far.

`Detector.step` is given one frame at a time, so that nothing can be known of later ones; but a class that keeps what
its other objects saw, or reads the folder of the frames, knows them. Whoever does is found by another order: the
frames up to the first contact in their own, the others backwards. What is said of the first ones stays, and of the
others it follows the frames.
"""

from itertools import islice

import numpy as np

from magicsim.errors import ConfigError
from magicsim.evaluation.answers import answers_to
from magicsim.evaluation.detector import Detection, MakeDetector
from magicsim.evaluation.footage import Footage

MOST_FRAMES = 120
"""Frames of an episode that are tried in another order, at most."""


def check_order(footage: Footage, make: MakeDetector, *, who: str) -> None:
    """Tries a detector on an episode's frames in their order and in another.

    Raises:
        ConfigError: It says other things of the first frames, or the same of others that came backwards.
    """
    references = list(footage.images.references())
    frames = list(islice(footage.images.frames(), MOST_FRAMES))
    met = np.flatnonzero(footage.labels.gap_mm[: len(frames)] <= 0)
    turn = int(met[0]) if len(met) else len(frames) // 2
    other = frames[:turn] + frames[turn:][::-1]
    before, after = (answers_to(each, references, make, footage.tag.take, who=who)[0] for each in (frames, other))
    name, take = f"detector '{who}'", footage.tag.take
    for place in range(turn):
        if _words(before[place]) != _words(after[place]):
            said = " then ".join("/".join(_words(each[place])) for each in (before, after))
            raise ConfigError(
                f"{name} reads the future, or differs from run to run: of frame {place} of {take} it said {said}, when "
                f"the frames from {turn} on came in another order; must follow from references and frames so far"
            )
    is_other = any(not np.array_equal(*pair) for pair in zip(frames[turn:], other[turn:], strict=True))
    if is_other and before[turn:] == after[turn:] and len(set(before[turn:])) > 1:
        raise ConfigError(
            f"{name} does not look at the frames: of those from {turn} on of {take} it said one after the other the "
            "same when they came backwards; must follow from references and frames so far"
        )


def _words(said: Detection) -> tuple[str, str]:
    return str(said.proximity), str(said.contact)
