"""A detector profile: every threshold and option of the three algorithms, with its range.

The defaults are the published values (Fan, Li, Zhang, arXiv 2505.24382); what the paper leaves open is marked
as assumed in the field's description.
"""

from dataclasses import Field, dataclass, field, fields
from typing import Literal, get_args

from magicsim.errors import ConfigError

SCHEMA_VERSION = 1
"""Version of the profile's keys."""

Polarity = Literal["dark", "bright"]
"""Which side of `tau_b` is the grid: pixels at or below it, or pixels above it."""

Similarity = Literal["recall", "iou", "dice"]
"""How the overlap of a frame's grid with the reference becomes one number in 0..1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What a field may be and what it means; stands in the field's metadata under `limits`."""

    about: str
    """One sentence for documentation and the JSON Schema."""
    low: float | None = None
    """Smallest allowed value."""
    high: float | None = None
    """Largest allowed value."""
    odd: bool = False
    """Whether the number is the side of a centred kernel: odd, or 0 for none."""
    choices: tuple[str, ...] = ()
    """The allowed words, for a text field."""

    def allowed(self, kind: type) -> str:
        """Say in words what is allowed for a value of type `kind` (int, float or str)."""
        if self.choices:
            return f"one of: {', '.join(self.choices)}"
        if self.low == self.high:
            return f"{self.low:g}"
        span = f"in {self.low:g}..{self.high:g}"
        if self.odd:
            return f"an odd whole number {span}, or 0 for none"
        return f"a {'whole ' if kind is int else ''}number {span}"


def _metadata(
    about: str,
    low: float | None = None,
    high: float | None = None,
    *,
    odd: bool = False,
    choices: tuple[str, ...] = (),
) -> dict[str, Limits]:
    """Metadata of one field."""
    return {"limits": Limits(about=about, low=low, high=high, odd=odd, choices=choices)}


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorProfile:
    """Thresholds and options of the detectors; one that is out of range cannot be constructed.

    Raises:
        ConfigError: A value has the wrong type or lies outside its range; the line names the field, the value
            and what is allowed.
    """

    schema_version: int = field(
        default=SCHEMA_VERSION, metadata=_metadata("Version of these keys.", SCHEMA_VERSION, SCHEMA_VERSION)
    )
    tau_e: float = field(default=0.5, metadata=_metadata("Entropy from which something brightens [bit].", 0.0, 8.0))
    tau_c: float = field(
        default=0.2, metadata=_metadata("Correlation from which a brightening is outside light.", -1.0, 1.0)
    )
    tau_b: int = field(
        default=35,
        metadata=_metadata("Grey level that separates grid from background; above is bright.", 0, 254),
    )
    tau_g: float = field(
        default=0.6, metadata=_metadata("Grid similarity below which the sensor is touched.", 0.0, 1.0)
    )
    background_count: int = field(default=3, metadata=_metadata("Background references M.", 1, 255))
    reference_count: int = field(
        default=30, metadata=_metadata("Frames N of the untouched sensor that make the references.", 1, 255)
    )
    grid_blur_px: int = field(
        default=5,
        metadata=_metadata("Side of the Gaussian kernel before binarising [px]; assumed.", 0, 63, odd=True),
    )
    difference_blur_px: int = field(
        default=0,
        metadata=_metadata("Side of the Gaussian kernel before the difference [px].", 0, 63, odd=True),
    )
    polarity: Polarity = field(
        default="dark",
        metadata=_metadata("Side of tau_b that is the grid; assumed.", choices=get_args(Polarity)),
    )
    similarity: Similarity = field(
        default="recall",
        metadata=_metadata("Measure of overlap with the reference grid.", choices=get_args(Similarity)),
    )
    entropy_width: float = field(
        default=0.25,
        metadata=_metadata("Logistic width of the entropy's probability [bit]; assumed.", 1e-6, 8.0),
    )
    correlation_width: float = field(
        default=0.05,
        metadata=_metadata("Logistic width of the correlation's probability; assumed.", 1e-6, 2.0),
    )
    similarity_width: float = field(
        default=0.05,
        metadata=_metadata("Logistic width of the similarity's probability; assumed.", 1e-6, 1.0),
    )

    def __post_init__(self) -> None:
        """Check every field, and turn whole numbers into floats where a float is asked for."""
        for each in fields(self):
            object.__setattr__(self, each.name, _checked(each, getattr(self, each.name)))
        if self.reference_count < self.background_count:
            msg = (
                f"reference_count = {self.reference_count} must be at least background_count = {self.background_count}"
            )
            raise ConfigError(msg)


def limits_of(each: "Field[object]") -> Limits:
    """The limits of one field of `DetectorProfile`."""
    limits: Limits = each.metadata["limits"]
    return limits


def kind_of(each: "Field[object]") -> type[int | float | str]:
    """The plain type of one field of `DetectorProfile`: int, float or str."""
    return type(each.default)  # type: ignore[return-value]


def _checked(each: "Field[object]", value: object) -> object:
    """The value in the field's own type, or an error that names field, value and what is allowed."""
    limits, kind = limits_of(each), kind_of(each)
    good = _in_choices(value, limits) if kind is str else _in_range(value, kind, limits)
    if not good:
        msg = f"{each.name} = {value!r} is not allowed; must be {limits.allowed(kind)}"
        raise ConfigError(msg)
    return float(value) if kind is float else value  # type: ignore[arg-type]


def _in_choices(value: object, limits: Limits) -> bool:
    return isinstance(value, str) and value in limits.choices


def _in_range(value: object, kind: type, limits: Limits) -> bool:
    numeric = isinstance(value, int if kind is int else (int, float)) and not isinstance(value, bool)
    if not numeric:
        return False
    inside = limits.low <= value <= limits.high  # type: ignore[operator]  # NaN is never inside
    return inside and (not limits.odd or value == 0 or value % 2 == 1)  # type: ignore[operator]
