"""A detector profile: every threshold and option of the three algorithms, with its range, file and schema.

The defaults are the published values (Fan, Li, Zhang, arXiv 2505.24382); what the paper leaves open is marked
as assumed in the field's description, with the reason for the default in a comment. `docs/detector-options.md` has the
measured effect of every choice.
"""

import dataclasses
import json
import os
import secrets
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, get_args

from magicsim.config.documents import read_toml
from magicsim.config.presets import find_preset
from magicsim.errors import NAME_LENGTH, ConfigError, OutputError, shortened, unknown_choice


@dataclass(frozen=True, slots=True, kw_only=True)
class OptionLimits:
    """What a field of the profile may be and what it means; stands in the field's metadata under `limits`."""

    about: str
    """One sentence for documentation and the JSON Schema."""
    low: float | None = None
    high: float | None = None
    odd: bool = False
    """Whether the number is the side of a centred kernel: odd, or 0 for none."""
    choices: tuple[str, ...] = ()
    """The allowed words, for a text field."""

    def allowed(self, kind: type) -> str:
        """What is allowed for a value of type `kind` (int, float or str), in words."""
        if self.choices:
            return f"one of: {', '.join(self.choices)}"
        if self.low == self.high:
            return f"{self.low:g}"
        span = f"in {self.low:g}..{self.high:g}"
        if self.odd:
            return f"an odd whole number {span}, or 0 for none"
        return f"a {'whole ' if kind is int else ''}number {span}"

    def admits(self, value: object, kind: type) -> bool:
        """Whether a value is one of the words, or a number of that type in the range."""
        if kind is str:
            return isinstance(value, str) and value in self.choices
        if not isinstance(value, int if kind is int else (int, float)) or isinstance(value, bool):
            return False
        inside = self.low <= value <= self.high  # type: ignore[operator]  # NaN is never inside
        return inside and (not self.odd or value == 0 or value % 2 == 1)


def option(
    default: float | str, about: str, low: float | None = None, high: float | None = None, *, odd: bool = False,
    choices: tuple[str, ...] = (),
) -> Any:  # noqa: ANN401  # fmt: skip
    """A field of the profile, with its default and what it may be (see `OptionLimits`)."""
    limits = OptionLimits(about=about, low=low, high=high, odd=odd, choices=choices)
    return field(default=default, metadata={"limits": limits})


SCHEMA_VERSION = 1
"""Version of the profile's keys."""
Polarity = Literal["dark", "bright"]
"""Which side of `tau_b` is the grid: pixels at or below it, or pixels above it."""
Similarity = Literal["recall", "iou", "dice"]
"""How the overlap of a frame's grid with the reference becomes one number in 0..1."""
GridKind = Literal["presence", "majority"]
"""What the grid reference keeps of the binarised frames: their mean, or that mean binarised at one half."""
Grey = Literal["luma", "mean"]
"""How three channels become one grey level: 0.299 R + 0.587 G + 0.114 B, or (R + G + B) / 3."""
Rounding = Literal["nearest", "down"]
"""How a grey level becomes 8 bit: to the nearest level (halves up), or cut off."""
Units = Literal["fixed", "rest"]
"""What thresholds mean: numbers for every sensor, or of the sensor at hand at rest (`magicsim.detectors.rest`)."""
ConstantChannel = Literal["zero", "skip"]
"""What a pair with a constant channel, which has no correlation, adds to the mean: 0, or nothing at all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorProfile:
    """Thresholds and options of the detectors; one that is out of range cannot be constructed.

    Raises:
        ConfigError: A value has the wrong type or lies outside its range; the line names the field, the value
            and what is allowed.
    """

    schema_version: int = option(SCHEMA_VERSION, "Version of these keys.", SCHEMA_VERSION, SCHEMA_VERSION)
    tau_e: float = option(0.5, "Entropy from which something brightens [bit].", 0.0, 8.0)
    tau_c: float = option(0.2, "Correlation from which a brightening is outside light.", -1.0, 1.0)
    tau_b: int = option(35, "Grey level that separates grid from background; above is bright.", 0, 254)
    tau_g: float = option(0.6, "Grid similarity below which the sensor is touched.", 0.0, 1.0)
    background_count: int = option(3, "Background references M.", 1, 255)
    reference_count: int = option(30, "Frames N of the untouched sensor that make the references.", 1, 255)
    grid_blur_px: int = option(5, "Side of the Gaussian kernel before binarising [px]; assumed.", 0, 63, odd=True)
    difference_blur_px: int = option(0, "Side of the Gaussian kernel before the difference [px].", 0, 63, odd=True)
    polarity: Polarity = option("dark", "Side of tau_b that is the grid; assumed.", choices=get_args(Polarity))
    similarity: Similarity = option(
        "recall", "Measure of overlap with the reference grid.", choices=get_args(Similarity)
    )
    # Gaussian as published; its side and sigma are not given, and OpenCV's sigma for a side is the customary choice.
    grid_blur_sigma_px: float = option(
        0.0, "Standard deviation of that kernel [px]; 0 is 0.15 sides + 0.35; assumed.", 0.0, 20.0
    )
    # The algorithm averages the binarised frames and does not binarise the average again.
    grid_reference: GridKind = option(
        "presence", "What the grid reference keeps of the binarised frames.", choices=get_args(GridKind)
    )
    # Not published: an object that covers the room, or a live exposure, changes the brightness of the whole image.
    surround_px: int = option(
        0,
        "Standard deviation of the surroundings that a pixel is compared with [px]; tau_b is then in per cent of "
        "their brightness. 0 compares with the grey level tau_b, as published.",
        0,
        63,
    )
    # The luma of ITU-R BT.601 is what a conversion to grey means where nothing else is said.
    grey: Grey = option(
        "luma", "How the filtered channels become grey for the entropy; assumed.", choices=get_args(Grey)
    )
    # Cutting off would hide a brightening of less than one level that the mean of the channels shows.
    grey_rounding: Rounding = option("nearest", "How that grey becomes 8 bit; assumed.", choices=get_args(Rounding))
    # One bin for each of the 256 grey levels is the entropy of the image itself.
    entropy_bins: int = option(256, "Bins of the histogram whose entropy is taken; assumed.", 2, 256)
    # Three pairs always weigh one third each, so a channel that falls silent cannot make C jump.
    constant_channel: ConstantChannel = option(
        "zero", "What a pair with a constant channel adds to C; assumed.", choices=get_args(ConstantChannel)
    )
    # Not published: E, C and S at rest differ from sensor to sensor by more than a touch changes them.
    units: Units = option(
        "fixed",
        "Whether thresholds are fixed numbers, as published, or in units of the untouched sensor: tau_e in bits above "
        "E at rest, tau_c as a share of the way from the untouched picture's likeness to 1, tau_g as a share of S at "
        "rest, and tau_b as the per cent of its pixels that are the grid.",
        choices=get_args(Units),
    )
    entropy_width: float = option(0.25, "Logistic width of the entropy's probability [bit]; assumed.", 1e-6, 8.0)
    correlation_width: float = option(0.05, "Logistic width of the correlation's probability; assumed.", 1e-6, 2.0)
    similarity_width: float = option(0.05, "Logistic width of the similarity's probability; assumed.", 1e-6, 1.0)
    # Published runs see proximity 10 to 15 frames before contact, so that five leave as many to close in.
    approach_frames: int = option(
        5, "Approaching frames, not broken by Normal or Noise, before closing; assumed.", 1, 1000
    )
    entropy_hysteresis: float = option(
        0.1, "How far E may fall below tau_e without breaking that run [bit]; assumed.", 0.0, 8.0
    )
    touch_frames: int = option(2, "Touched frames in a row before an object counts as grasped; assumed.", 1, 1000)
    # In shares of 1 - tau_g and 1 - S, so that one value serves designs whose S spans very different ranges.
    touch_hysteresis: float = option(
        0.25, "Share of 1 - tau_g that S must rise above tau_g before a touch is lost; assumed.", 0.0, 1.0
    )
    transport_frames: int = option(3, "Frames held without a slip before transport begins; assumed.", 1, 1000)
    slip_share: float = option(
        0.25, "Share of the lost similarity 1 - S that returns suddenly in a slip; assumed.", 0.01, 1.0
    )
    slip_window: int = option(2, "Frames within which that share must return; assumed.", 1, 100)
    slip_entropy_rise: float = option(
        0.2, "Rise of E from which a rise of S is light and no slip [bit]; assumed.", 0.0, 8.0
    )
    close_frames: int = option(150, "Frames of closing without a touch before the gripper returns.", 1, 100_000)
    return_frames: int = option(5, "Untouched frames in a row before a returned gripper waits again.", 1, 1000)

    def __post_init__(self) -> None:
        """Check every field, and turn whole numbers into floats where a float is asked for."""
        for each in fields(self):
            value, kind, limits = getattr(self, each.name), type(each.default), each.metadata["limits"]
            if not limits.admits(value, kind):
                given = shortened(repr(value), NAME_LENGTH)
                raise ConfigError(f"{each.name} = {given} is not allowed; must be {limits.allowed(kind)}")
            if kind is float:
                object.__setattr__(self, each.name, float(value))
        if self.units == "rest" and (self.tau_b > 100 or self.surround_px):  # noqa: PLR2004
            raise ConfigError(
                f"tau_b = {self.tau_b} with surround_px = {self.surround_px} is not allowed with units = 'rest'; must "
                "be a whole number in 0..100, per cent of the pixels, with surround_px = 0"
            )
        if self.reference_count < self.background_count:
            raise ConfigError(
                f"reference_count = {self.reference_count} must be at least background_count = {self.background_count}"
            )


def load_profile(name_or_path: str | Path) -> DetectorProfile:
    """Read a profile by its shipped name (`published`) or from the user's own TOML file.

    Keys that the file leaves out keep their published values.

    Raises:
        PresetError: There is no such profile.
        ConfigError: Not valid TOML, an unknown key, or a value of the wrong type or out of range; the line
            names the file, the field, the value and what is allowed.
    """
    path = find_preset("profile", name_or_path)
    values = read_toml(path)
    names = {each.name for each in dataclasses.fields(DetectorProfile)}
    for key in values:
        if key not in names:
            raise ConfigError(f"profile file '{path}': {unknown_choice('key', key, names)}")
    try:
        return DetectorProfile(**values)
    except ConfigError as error:
        raise ConfigError(f"profile file '{path}': {error}") from error


def save_profile(profile: DetectorProfile, path: str | Path, *, comment: str) -> None:
    """Write a profile as TOML that `load_profile` reads back unchanged.

    Args:
        profile: What to write.
        path: The file; replaced whole or not at all.
        comment: Opening comment that says what the profile describes; may have several lines.

    Raises:
        ConfigError: The comment is empty.
        OutputError: The file cannot be written.
    """
    if not comment.strip():
        raise ConfigError("comment is empty; a profile file opens with a comment that says what it describes")
    lines = [f"# {line}".rstrip() for line in comment.strip().splitlines()]
    # JSON's numbers and short words are TOML's too, and Python writes floats so that they read back exactly.
    lines += [f"{name} = {json.dumps(value)}" for name, value in dataclasses.asdict(profile).items()]
    target = Path(path)
    partial = target.with_name(f".{target.name}.{secrets.token_hex(8)}.partial")
    try:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
        os.replace(partial, target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(f"profile file '{target}' cannot be written: {error.strerror}") from error


def profile_schema() -> dict[str, object]:
    """The JSON Schema (draft 2020-12) of a detector profile."""
    properties = {each.name: _property(each) for each in dataclasses.fields(DetectorProfile)}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "DetectorProfile",
        "description": "Thresholds and options of the detectors.",
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


def _property(each: "dataclasses.Field[object]") -> dict[str, object]:
    limits: OptionLimits = each.metadata["limits"]
    kinds: dict[type, str] = {int: "integer", float: "number", str: "string"}
    entry: dict[str, object] = {
        "type": kinds[type(each.default)], "description": limits.about, "default": each.default,
    }  # fmt: skip
    if limits.choices:
        return entry | {"enum": list(limits.choices)}
    entry |= {"minimum": limits.low, "maximum": limits.high}
    if limits.odd:
        entry["anyOf"] = [{"const": 0}, {"not": {"multipleOf": 2}}]
    return entry
