"""What is known of one design when it has been judged, and the folder of a sweep, one file a design.

Printing limits are mini-MagicTac's recommended and printed sizes (Fan, Li, Zhang, arXiv 2505.24382). The thinnest wall
is assumed: nobody published one, and 0.1 to 0.2 mm are the plausible walls of the base design.
"""

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

from pydantic import Field

from magicsim.config.documents import each_leaf, parse_json, without_nan
from magicsim.errors import OutputError
from magicsim.sweep.measures import Measured
from magicsim.workers.run_folder import CONFIG, RunFolder, RunIndex

Curve = dict[str, list[float | None]]
"""Columns of equal length."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """The design as it would be printed, for a drawing and for the table; all lengths in mm."""

    footprint_mm: tuple[float, float]
    height_mm: float
    skin_mm: float
    wall_mm: float
    counts: tuple[int, int, int] | None
    """Cells along x, y and z; None without a grid."""
    cell_mm: tuple[float, float, float] | None
    """Edges of a cell as resolved."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignResult:
    """One judged design."""

    index: int
    values: dict[str, float | str]
    is_extra: bool
    block: Block
    measures: dict[str, Measured]
    curves: dict[str, Curve] = field(default_factory=dict)
    pictures: dict[str, str] = field(default_factory=dict)
    """Data URIs by caption."""
    profile: dict[str, Any] = field(default_factory=dict)
    """Options and thresholds of the detector that was fitted to the design."""
    room: str | None = None
    """Room that the sensor stands in: a preset, `dark`, a file, or None for even light."""
    passes: bool = False
    """Whether something passes in it."""
    drawn: dict[str, float] = field(default_factory=dict)
    """Cameras and prints of the renderings, see `rows_of_renderings`; empty where all are alike."""
    seconds: float = 0.0
    """Wall time of judging it [s]."""

    def to_json(self) -> bytes:
        """The result as a JSON document."""
        return (json.dumps(finite(asdict(self)), allow_nan=False) + "\n").encode()

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """Reads what `to_json` wrote."""
        data = parse_json(text if isinstance(text, str) else text.decode(), source="the result")
        block = data.pop("block")
        for name in ("footprint_mm", "counts", "cell_mm"):
            block[name] = tuple(block[name]) if block[name] is not None else None
        measures = {name: Measured(**each) for name, each in data.pop("measures").items()}
        return cls(block=Block(**block), measures=measures, **data)


def finite(value: Any) -> Any:  # noqa: ANN401 - any nesting that JSON has
    """A value with None for numbers that JSON does not know, and floats of a length that a reader needs."""
    return each_leaf(without_nan(value), lambda each: float(f"{each:.8g}") if isinstance(each, float) else each)


INDEX, DESIGNS, REPORT = "sweep.json", "designs", "report.html"
CSV, PARQUET, FRAMES = "sweep.csv", "sweep.parquet", "frames"


class SweepIndex(RunIndex):
    """What a folder's results belong to."""

    designs: int
    failed: dict[str, str] = Field(default_factory=dict)
    """Why there is no result, by number of the design."""


FOLDER = RunFolder(
    index=INDEX, model=SweepIndex, noun="sweep", content="sweep",
    is_worth_keeping=lambda out, _: any((out / DESIGNS).glob("*.json")),
    title=f"A sweep of magicsim, everything in place: `magicsim sweep {CONFIG}`",
)  # fmt: skip


def result_name(index: int) -> str:
    """Name of a design's result below the folder."""
    return f"{DESIGNS}/{index:05d}.json"


def read_results(out: Path, count: int) -> list[DesignResult]:
    """All results of a sweep's designs, in order; a design without one is left out."""
    return [result for index in range(count) if (result := read_result(out, index)) is not None]


def read_result(out: Path, index: int) -> DesignResult | None:
    """A design's result, None without one."""
    path = out / result_name(index)
    try:
        return DesignResult.from_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError) as error:
        msg = f"'{path}' is not a result of a sweep: {error}; without it, --resume judges the design again"
        raise OutputError(msg) from None


LIMITS = {
    "skin_mm": (("printed skin", 0.3, 3.0), ("recommended skin", 0.5, 1.0)),
    "cell_mm": (("printed cell", 0.6, 1.0),),
    "height_mm": (("printed height", 2.0, 20.0),),
    "core_mm": (("recommended core", 4.0, 6.0),),
    "wall_mm": (("assumed thinnest wall", 0.1, math.inf),),
}
"""Ranges of each size that prints come out in, by name: least and largest [mm]; the core is to be 'about 5 mm'."""
SLACK_MM = 1e-6


def printability(block: Block) -> Measured:
    """Share of the limits that a block keeps, with the names of those it does not."""
    core = block.height_mm - 2 * block.skin_mm
    sizes = {"skin_mm": block.skin_mm, "height_mm": block.height_mm, "core_mm": core}
    if block.cell_mm is not None:  # as resolved, the smallest edge
        sizes |= {"cell_mm": round(min(block.cell_mm), 6), "wall_mm": block.wall_mm}
    kept, broken = 0, []
    for name, value in sizes.items():
        for what, low, high in LIMITS[name]:
            if low - SLACK_MM <= value <= high + SLACK_MM:
                kept += 1
            else:
                span = f"at least {low:g}" if high == math.inf else f"{low:g} to {high:g}"
                broken.append(f"{what} {span} mm, here {value:.3g}")
    share = kept / (kept + len(broken))
    return Measured(value=share, low=share, high=share, note="; ".join(broken))
