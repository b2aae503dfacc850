"""What a detector answers to the frames of an episode, checked."""

import math
from collections.abc import Iterable
from typing import Any

from magicsim.arrays import Frame
from magicsim.detectors.at_rest import FEATURES
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.errors import ConfigError, unknown_choice
from magicsim.evaluation.detector import Detection, Detector, MakeDetector
from magicsim.evaluation.foreign import tried


def fitted(make: MakeDetector, references: Iterable[Frame], *, who: str) -> Detector:
    """A new detector that has learned the untouched sensor.

    Raises:
        MagicsimError: A frame cannot be used, or the detector raised something.
    """
    detector = make()
    tried(lambda: detector.fit(list(references)), f"detector '{who}': fit raised")
    return detector


def answered(detector: Detector, frame: Frame, *, who: str) -> Detection:
    """What a detector says of the next frame.

    Raises:
        MagicsimError: The frame cannot be used, the detector raised something, or it does not answer as it must.
    """
    return check_detection(tried(lambda: detector.step(frame), f"detector '{who}': step raised"), who=who)


def check_detection(said: object, *, who: str) -> Detection:
    """A plug-in's answer, checked.

    Raises:
        ConfigError: One of the first four fields is missing, a verdict unknown, or a score not a finite number.
    """
    values: dict[str, Any] = {name: _number(getattr(said, name, None)) for name in FEATURES}
    for field in ("proximity", "contact", "approach", "touch"):
        if not hasattr(said, field):
            msg = f"detector '{who}': step returned {type(said).__name__} without {field}; must be like Detection"
            raise ConfigError(msg)
        values[field] = getattr(said, field)
    for field, choices in (("proximity", Proximity), ("contact", Contact)):
        if values[field] not in list(choices):
            raise ConfigError(f"detector '{who}': {unknown_choice(field, str(values[field]), choices)}")
    for field in ("approach", "touch"):
        score = _number(values[field])
        if score is None:
            msg = f"detector '{who}': {field} = {values[field]!r} is not allowed: must be a finite number"
            raise ConfigError(msg)
        values[field] = score
    return Detection(**values)


def _number(value: object) -> float | None:
    """A finite number, None where it is none."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None
