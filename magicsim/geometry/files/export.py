"""Printable and viewable geometry: the clear part with its cavities, and the infill, as files for other programs.

3MF (for printers, in millimetres) is written by the format's reference library; GLB (for viewers) is in metres with y
up, so that its nodes carry scale and rotation.
"""

import hashlib
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np
import trimesh
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

from magicsim.errors import GeometryError, OutputError
from magicsim.folder import PRODUCER, check_file, refuse_unsigned, result_file
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import Elastomer, build_elastomer
from magicsim.geometry.flaws import Inclusions, Roughness, Unevenness
from magicsim.geometry.mesh import SurfaceMesh

SUFFIXES = (".stl", ".3mf", ".glb")
METRES_PER_MM = 1e-3
TO_VIEWER = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1 / METRES_PER_MM]]) * METRES_PER_MM
"""From the sensor's frame [mm] to glTF's [m]: the contact face looks down, the sensor's z axis points up (y)."""
Colour = tuple[float, float, float, float]
CLEAR: Colour = (0.80, 0.90, 1.00, 0.25)
"""Display colour of skin and walls, RGBA in 0..1."""
TRANSLUCENT: Colour = (1.00, 0.93, 0.75, 0.60)
"""Display colour of the infill."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedPart:
    """One material of a print."""

    name: str
    mesh: SurfaceMesh
    """Closed surface in the sensor's frame [mm]."""
    colour: Colour
    """How viewers show it, RGBA in 0..1; no property of the material."""


def printed_parts(elastomer: Elastomer) -> tuple[PrintedPart, ...]:
    """The clear part with its cells hollow, then the infill if there is one; they do not overlap."""
    body, infill = elastomer.body, elastomer.infill
    if infill is None:
        return (PrintedPart(name="body", mesh=body, colour=CLEAR),)
    hollow = SurfaceMesh(  # the infill's surfaces turned inside out
        vertices=np.concatenate([body.vertices, infill.vertices]),
        faces=np.concatenate([body.faces, infill.faces[:, ::-1] + len(body.vertices)]).astype(np.int32),
    )
    return (
        PrintedPart(name="body", mesh=hollow, colour=CLEAR),
        PrintedPart(name="infill", mesh=infill, colour=TRANSLUCENT),
    )


def write_3mf(path: Path, parts: Sequence[PrintedPart]) -> None:
    """Writes the parts as the components of one object, which slicers keep aligned.

    Positions are stored in single precision, as the library does.

    `OutputError` where there is no 3MF library for this processor, `GeometryError` where it takes a mesh for open.
    """
    try:
        import lib3mf
    except ImportError:
        msg = "3MF files need lib3mf, which is not installed; it is not made for every processor: write .stl or .glb"
        raise OutputError(msg) from None
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(lib3mf.ModelUnit.MilliMeter)
    model.SetBuildUUID(_identity("build", parts))
    materials = model.AddBaseMaterialGroup()
    sensor = model.AddComponentsObject()
    sensor.SetName("sensor")
    sensor.SetUUID(_identity("sensor", parts))
    place = wrapper.GetIdentityTransform()
    for part in parts:
        solid = model.AddMeshObject()
        solid.SetName(part.name)
        solid.SetUUID(_identity("solid", [part]))
        solid.SetGeometry(
            _structures(lib3mf.Position, part.mesh.vertices.astype(np.float32)),
            _structures(lib3mf.Triangle, part.mesh.faces.astype(np.uint32)),
        )
        if not solid.IsManifoldAndOriented():
            raise GeometryError(f"the {part.name} mesh is not closed and oriented in single precision")
        material = materials.AddMaterial(part.name, wrapper.FloatRGBAToColor(*part.colour))
        solid.SetObjectLevelProperty(materials.GetUniqueResourceID(), material)
        sensor.AddComponent(solid, place).SetUUID(_identity("component", [part]))
    model.AddBuildItem(sensor, place).SetUUID(_identity("item", parts))
    path.write_bytes(bytes(model.QueryWriter("3mf").WriteToBuffer()))


def _identity(role: str, parts: Sequence[PrintedPart]) -> str:
    """An identifier that follows from the content, so that the same design gives the same bytes."""
    digest = hashlib.blake2b(role.encode(), digest_size=16)
    for part in parts:
        digest.update(part.name.encode() + part.mesh.vertices.tobytes() + part.mesh.faces.tobytes())
    return str(UUID(bytes=digest.digest(), version=4))


def _structures(kind: Any, rows: np.ndarray[Any, Any]) -> Any:  # noqa: ANN401 - ctypes arrays
    return (kind * len(rows)).from_buffer_copy(np.ascontiguousarray(rows).tobytes())


def write_glb(path: Path, parts: Sequence[PrintedPart]) -> None:
    """Writes the parts as named nodes; the stored vertices are in mm, the nodes' matrices make them metres."""
    scene = trimesh.Scene()
    for part in parts:
        mesh = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
        material = PBRMaterial(  # type: ignore[no-untyped-call]
            name=part.name, baseColorFactor=part.colour, metallicFactor=0.0, roughnessFactor=0.2, alphaMode="BLEND",
            doubleSided=False,
        )  # fmt: skip
        mesh.visual = TextureVisuals(material=material)  # type: ignore[no-untyped-call]
        scene.add_geometry(mesh, node_name=part.name, geom_name=part.name, transform=TO_VIEWER)
    # Without normals viewers shade each triangle flat, as the glTF specification (section 3.7.2.1) asks
    path.write_bytes(scene.export(file_type="glb", include_normals=False))  # type: ignore[no-untyped-call]


@dataclass(frozen=True, slots=True, kw_only=True)
class Export:
    """Written files and their volumes."""

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
        raise OutputError(f"out = '{out}' is not allowed: must end in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    check_file(out)
    as_drawn = {"unevenness": Unevenness(), "roughness": Roughness(), "inclusions": Inclusions()}
    parts = printed_parts(build_elastomer(design.model_copy(update=as_drawn)))
    others = parts[1:] if out.suffix == ".stl" else ()
    paths = [out, *(out.with_name(f"{out.stem}-{part.name}.stl") for part in others)]
    for path in paths[1:]:
        refuse_unsigned(path)
    _write(paths, parts)
    return Export(
        files=[str(path) for path in paths],
        watertight=all(part.mesh.is_watertight() for part in parts),
        volume_mm3=parts[0].mesh.volume_mm3(),
        infill_volume_mm3=sum(part.mesh.volume_mm3() for part in parts[1:]),
    )


def _write(paths: Sequence[Path], parts: Sequence[PrintedPart]) -> None:
    """Writes all files beside their final names first, so that no part stands there alone."""
    with ExitStack() as files:
        partials = [files.enter_context(result_file(path)) for path in paths]
        if paths[0].suffix == ".3mf":
            write_3mf(partials[0], parts)
        elif paths[0].suffix == ".glb":
            write_glb(partials[0], parts)
        else:
            for partial, part in zip(partials, parts, strict=True):
                trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False).export(partial)
                with partial.open("rb+") as file:  # the 80 bytes before the triangles are anybody's
                    file.write(PRODUCER.encode())
