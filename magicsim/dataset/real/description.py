"""What a user says of recorded frames: the configuration of `magicsim dataset import`."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.documents import read_toml
from magicsim.config.models import Config, apply_overrides, validate
from magicsim.config.presets import expanded, is_file
from magicsim.errors import NAME_LENGTH, PresetError, shortened

Text = Annotated[str, Field(pattern=r"\S", max_length=1000)]
Factor = Annotated[float, Field(ge=-1e9, le=1e9)]
Edge = Annotated[int, Field(ge=0, le=20_000)]
Pixels = Annotated[int, Field(ge=8, le=20_000)]
Split = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_]*$", max_length=40)]
ClassName = Literal["Clear", "Near", "Contact", "Light", ""]
Vector = tuple[Text, Text, Text]


class FrameForm(Config):
    """What turns recorded frames into those that magicsim reads: RGB, row 0 at +y, column 0 at -x. In this order."""

    color_order: Literal["rgb", "bgr"] = "rgb"
    """`bgr` exchanges red and blue, where whoever saved the frames has exchanged them."""
    crop_px: tuple[Edge, Edge, Pixels, Pixels] | None = None
    """Part that is kept: first column, first row, columns, rows; all of it by default [px]."""
    rotate_deg: Literal[0, 90, 180, 270] = 0
    """Turn of the picture, counter-clockwise [degrees]."""
    mirror: bool = False
    """Whether left and right are exchanged, after the turn."""
    size_px: tuple[Pixels, Pixels] | None = None
    """Columns and rows of the result, by averaging or interpolating; as they are by default [px]."""


class LabelColumns(Config):
    """Names of the columns of the CSV files with labels; what is left out is not known."""

    image: Text = "image_name"
    """File name of the frame, relative to the folder of frames; its ending may be missing. Not used with a video."""
    time_s: Text | None = None
    """Time: of the frame, or, with a video, of the label."""
    episode: Text | None = None
    """What tells apart episodes within one recording: any text."""
    is_reference: Text | None = None
    """1 for frames of the untouched sensor that detectors learn from, else 0."""
    frame_class: Text | None = None
    """Class of the frame: `Clear`, `Near`, `Contact`, `Light` or nothing; `truth.classes` translates other words."""
    contact: Text | None = None
    """1 where something touches, else 0."""
    flashlight: Text | None = None
    """1 where an outside light is on, else 0."""
    gap_mm: Text | None = None
    """Gap to the undeformed face, negative when pressed, empty without an object."""
    depth_mm: Text | None = None
    """Depth of the press."""
    place_mm: tuple[Text, Text] | Vector | None = None
    """Place of the object along x and y, or x, y and z."""
    force_n: Text | Vector | None = None
    """Force on the sensor along x, y and z, a press being +z; or one column with the force of the press."""
    torque_nmm: Vector | None = None
    """Torque about the origin."""
    twist_deg: Text | None = None
    """Turn of the object about z."""
    contact_area_mm2: Text | None = None
    """Area that touches."""
    object_kind: Text | None = None
    """What the object is: any text."""


PUBLIC = LabelColumns(force_n=("fx", "fy", "fz"))
"""Layout of public sets: a folder of images beside a CSV `image_name,fx,fy,fz`."""


class Scales(Config):
    """Factors from the units and signs of the CSV files to those of the columns."""

    time_s: Factor = 1.0
    gap_mm: Factor = 1.0
    depth_mm: Factor = 1.0
    place_mm: tuple[Factor, Factor, Factor] | Factor = 1.0
    force_n: tuple[Factor, Factor, Factor] | Factor = 1.0
    torque_nmm: tuple[Factor, Factor, Factor] | Factor = 1.0
    twist_deg: Factor = 1.0
    contact_area_mm2: Factor = 1.0


class TruthRules(Config):
    """How classes of frames follow from labels that say them indirectly."""

    contact_n: Annotated[float, Field(ge=0, le=1e4)] = 0.05
    """Force above which something touches, where nothing says it directly [N]; assumed, the noise of a small sensor."""
    without_contact: Literal["Clear", "Near", ""] = ""
    """Class of frames without contact whose gap is not known; none by default: they are not scored."""
    classes: Mapping[str, ClassName] = Field(default_factory=dict)
    """From the words of the column `frame_class` to classes."""


class RecordingSource(Config):
    """Frames that were taken in one go, with one exposure."""

    frames: Text
    """Folder of images, or a video, relative to this file."""
    labels: Text | None = None
    """CSV file with a heading, relative to this file."""
    untouched: Text | None = None
    """Folder of images, image or video of the untouched sensor at that exposure."""
    untouched_first: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """So many first frames of the recording instead."""
    untouched_below_n: Annotated[float, Field(ge=0, le=1e4)] | None = None
    """The 30 frames of least force instead, all of them below so much [N]."""
    gain: Annotated[float, Field(gt=0, le=20)] = 1.0
    """Factor on the grey levels of the frames that are not references."""
    offset_s: Annotated[float, Field(ge=-1e10, le=1e10)] = 0.0
    """What is added to the times of a video, as its container has them, to get those of its labels [s]."""
    path_kind: Annotated[str, Field(max_length=200)] = "recorded"
    """What happens in it."""
    object_kind: Annotated[str, Field(max_length=200)] = ""
    """What the object is, where no column says it."""
    sensor: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Number of the sensor."""
    split: Split = "train"
    """Part of the dataset that it goes into."""

    def _problems(self) -> Iterator[str | None]:
        given = [
            name for name in ("untouched", "untouched_first", "untouched_below_n") if getattr(self, name) is not None
        ]
        if len(given) > 1:
            yield f"{given[1]} is not allowed with {given[0]}: references come from one place"


class Description(Config):
    """Recorded frames, their labels, and how to read both."""

    schema_version: Literal[1]
    license: Annotated[str, Field(max_length=200)] | None = None
    """For the dataset's card; yours to choose."""
    like: Text | None = None
    """Run or dataset that the untouched frames should resemble: size, orientation, order of colours and exposure are
    compared with its own."""
    frames_per_second: Annotated[float, Field(gt=0, le=100_000)] | None = None
    """Frame rate of folders without times [1/s]; videos and labels with times have their own."""
    most_gap_s: Annotated[float, Field(gt=0, le=1e6)] = 0.1
    """Labels of a video are interpolated between rows at most so far from the frame, and missing elsewhere [s]."""
    frames: FrameForm = FrameForm()
    columns: LabelColumns = PUBLIC
    """`image_name,fx,fy,fz` by default."""
    scale: Scales = Scales()
    truth: TruthRules = TruthRules()
    recordings: Annotated[tuple[RecordingSource, ...], Field(min_length=1, max_length=10_000)]


@dataclass(frozen=True, slots=True, kw_only=True)
class RealSource:
    """A description and the folder that its paths start in."""

    description: Description
    folder: Path

    def path(self, name: str) -> Path:
        """Where a file or folder that the description names is."""
        return self.folder / expanded(name)


def load_real(path: str | Path, overrides: Sequence[str] = ()) -> RealSource:
    """Reads what a user says of recorded frames.

    Args:
        path: TOML file (`docs/real-data.md`); the paths in it start in its folder.
        overrides: `dotted.key=value` settings.

    Raises:
        PresetError: There is no such file.
        ConfigError: The content is not acceptable.
    """
    file = expanded(path)
    if not is_file(file):
        raise PresetError(f"description '{shortened(str(path), 2 * NAME_LENGTH)}' does not exist; must be a TOML file")
    description = validate(Description, apply_overrides(read_toml(file), overrides), source=file.name)
    return RealSource(description=description, folder=file.parent)
