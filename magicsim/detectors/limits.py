"""What each field of a dataclass of options may be: kept beside the field, checked when it is constructed."""

from dataclasses import Field, dataclass, field
from typing import Any

from magicsim.errors import NAME_LENGTH, ConfigError, shortened


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


def option(
    default: float | str,
    about: str,
    low: float | None = None,
    high: float | None = None,
    *,
    odd: bool = False,
    choices: tuple[str, ...] = (),
) -> Any:  # noqa: ANN401 - a field of whatever type its default has
    """A field of a dataclass of options, with its default and what it may be (see `Limits`)."""
    limits = Limits(about=about, low=low, high=high, odd=odd, choices=choices)
    return field(default=default, metadata={"limits": limits})


def limits_of(each: "Field[object]") -> Limits:
    """The limits of one field of a dataclass of options."""
    limits: Limits = each.metadata["limits"]
    return limits


def kind_of(each: "Field[object]") -> type[int | float | str]:
    """The plain type of one field of a dataclass of options: int, float or str."""
    return type(each.default)  # type: ignore[return-value]


def checked(each: "Field[object]", value: object) -> object:
    """The value in the field's own type, or an error that names field, value and what is allowed."""
    limits, kind = limits_of(each), kind_of(each)
    good = _in_choices(value, limits) if kind is str else _in_range(value, kind, limits)
    if not good:
        msg = f"{each.name} = {shortened(repr(value), NAME_LENGTH)} is not allowed; must be {limits.allowed(kind)}"
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
