"""Printable and viewable geometry: the clear part with its cavities, and the infill, as files for other programs."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import trimesh

from magicsim.errors import OutputError
from magicsim.folder import PRODUCER, check_file, refuse_unsigned, result_file
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.files.glb import write_glb
from magicsim.geometry.files.part import Part, printed_parts
from magicsim.geometry.files.threemf import write_3mf

SUFFIXES = (".stl", ".3mf", ".glb")


@dataclass(frozen=True, slots=True, kw_only=True)
class Export:
    """What was written."""

    watertight: bool
    """Whether every written mesh is closed."""
    volume_mm3: float
    """Volume of the clear part: block minus cells [mm3]."""
    infill_volume_mm3: float
    """Volume of the infill [mm3]; 0 without a grid."""
    files: list[str]
    """Files written; of STL, which holds one part, the clear part and then the infill if there is one."""


def export_design(design: ElastomerDesign, out: Path | str) -> Export:
    """Builds a design and writes its parts `body` and, with a grid, `infill`.

    Args:
        design: The block.
        out: Its suffix chooses the format. `.3mf` (mm) and `.glb` (m, as glTF asks) hold both parts; with `.stl` (mm)
            the infill goes beside the body as `NAME-infill.stl`.

    Raises:
        GeometryError: The design cannot be built.
        OutputError: The name ends in something else, or the files cannot be written.
    """
    out = Path(out)
    if out.suffix not in SUFFIXES:
        msg = f"out = '{out}' is not allowed: must end in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        raise OutputError(msg)
    check_file(out)
    parts = printed_parts(build_elastomer(design.as_drawn()))
    for path in _paths(out, parts)[1:]:
        refuse_unsigned(path)
    return Export(
        files=[str(path) for path in _write(out, parts)],
        watertight=all(part.mesh.is_watertight() for part in parts),
        volume_mm3=parts[0].mesh.volume_mm3(),
        infill_volume_mm3=sum(part.mesh.volume_mm3() for part in parts[1:]),
    )


def _write(out: Path, parts: Sequence[Part]) -> list[Path]:
    """Writes all files beside their final names first, so that no part stands there alone."""
    if out.suffix != ".stl":
        with result_file(out) as partial:
            write = write_3mf if out.suffix == ".3mf" else write_glb
            write(partial, parts)
        return [out]
    paths = _paths(out, parts)
    with ExitStack() as files:
        for partial, part in zip([files.enter_context(result_file(path)) for path in paths], parts, strict=True):
            trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False).export(partial)
            with partial.open("rb+") as file:  # the 80 bytes before the triangles are anybody's
                file.write(PRODUCER.encode())
    return paths


def _paths(out: Path, parts: Sequence[Part]) -> list[Path]:
    """The file that was named, and of STL those beside it."""
    others = parts[1:] if out.suffix == ".stl" else []
    return [out, *(out.with_name(f"{out.stem}-{part.name}{out.suffix}") for part in others)]
