"""3MF files for printers: millimetres, named parts with their materials, written by the format's reference library."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np

from magicsim.errors import GeometryError, OutputError
from magicsim.geometry.files.part import Part


def write_3mf(path: Path, parts: Sequence[Part]) -> None:
    """Writes the parts as the components of one object, which slicers keep aligned.

    Positions are stored in single precision, as the library does.

    Raises:
        OutputError: There is no 3MF library for this processor.
        GeometryError: The library does not take a mesh for a closed solid.
        OSError: The file cannot be written.
    """
    lib3mf = _library()
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
            msg = f"the {part.name} mesh is not closed and oriented in single precision"
            raise GeometryError(msg)
        material = materials.AddMaterial(part.name, wrapper.FloatRGBAToColor(*part.colour))
        solid.SetObjectLevelProperty(materials.GetUniqueResourceID(), material)
        sensor.AddComponent(solid, place).SetUUID(_identity("component", [part]))
    model.AddBuildItem(sensor, place).SetUUID(_identity("item", parts))
    path.write_bytes(bytes(model.QueryWriter("3mf").WriteToBuffer()))


def _identity(role: str, parts: Sequence[Part]) -> str:
    """An identifier that follows from the content, so that the same design gives the same bytes."""
    digest = hashlib.blake2b(role.encode(), digest_size=16)
    for part in parts:
        digest.update(part.name.encode() + part.mesh.vertices.tobytes() + part.mesh.faces.tobytes())
    return str(UUID(bytes=digest.digest(), version=4))


def _structures(kind: Any, rows: np.ndarray[Any, Any]) -> Any:  # noqa: ANN401 - ctypes arrays
    return (kind * len(rows)).from_buffer_copy(np.ascontiguousarray(rows).tobytes())


def _library() -> Any:  # noqa: ANN401 - its bindings have no types
    try:
        import lib3mf
    except ImportError:
        msg = "3MF files need lib3mf, which is not installed; it is not made for every processor: write .stl or .glb"
        raise OutputError(msg) from None
    return lib3mf
