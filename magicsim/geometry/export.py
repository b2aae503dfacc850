"""Printable geometry: the clear part with its cavities, and the infill, as separate STL files in mm."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from magicsim.errors import OutputError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.mesh import SurfaceMesh

SUFFIXES = (".stl",)


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
    """Files written: the clear part, then the infill if there is one."""


def export_design(design: ElastomerDesign, out: Path) -> Export:
    """Builds a design and writes its parts; the infill goes beside the clear part as `NAME-infill.stl`.

    Raises:
        GeometryError: The design cannot be built.
        OutputError: The name does not end in `.stl`, or the files cannot be written.
    """
    if out.suffix not in SUFFIXES:
        msg = f"out = '{out}' is not allowed: must end in {' or '.join(SUFFIXES)}"
        raise OutputError(msg)
    elastomer = build_elastomer(design)
    parts = {out: elastomer.body}
    if elastomer.infill is not None:
        parts = {out: _with_cavities(elastomer.body, elastomer.infill)}
        parts[out.with_name(f"{out.stem}-infill{out.suffix}")] = elastomer.infill
    _write(parts)
    return Export(
        watertight=all(mesh.is_watertight() for mesh in parts.values()),
        volume_mm3=parts[out].volume_mm3(),
        infill_volume_mm3=elastomer.infill.volume_mm3() if elastomer.infill is not None else 0.0,
        files=[str(path) for path in parts],
    )


def _with_cavities(body: SurfaceMesh, infill: SurfaceMesh) -> SurfaceMesh:
    """The body with the infill's surfaces turned inside out, which makes the cells hollow."""
    return SurfaceMesh(
        vertices=np.concatenate([body.vertices, infill.vertices]),
        faces=np.concatenate([body.faces, infill.faces[:, ::-1] + len(body.vertices)]).astype(np.int32),
    )


def _write(parts: Mapping[Path, SurfaceMesh]) -> None:
    """Writes all parts beside their final names first, so that no part stands there alone."""
    partials = {path: path.with_name(f".{path.stem}.partial{path.suffix}") for path in parts}
    try:
        for path, partial in partials.items():
            if path.is_dir():
                msg = f"output file '{path}' is a folder; name a file"
                raise OutputError(msg)
            path.parent.mkdir(parents=True, exist_ok=True)
            trimesh.Trimesh(parts[path].vertices, parts[path].faces, process=False).export(partial)
        for path, partial in partials.items():
            partial.replace(path)
    except OSError as error:
        msg = f"cannot write {next(iter(parts))}: {error.strerror or error}"
        raise OutputError(msg) from None
    finally:
        for partial in partials.values():
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
