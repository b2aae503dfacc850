"""The sensors of a sweep: what a point of it changes, and how each is seen at a sweep's quality."""

from magicsim.camera.camera import Camera
from magicsim.config.models import Config
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings
from magicsim.sweep.judging.quality import Quality


class SweptSensor(Config):
    """Everything that a sweep may change; fields are named `design.skin_mm`, `rig.camera.gamma`, `render.samples`."""

    design: ElastomerDesign
    rig: Rig
    render: RenderSettings = RenderSettings()


def camera_of(sensor: SweptSensor, quality: Quality, *, scale: int = 1) -> Camera:
    """The sensor's camera with as many pixels as the quality asks for; its field and its noise a pixel stay.

    Args:
        sensor: Whose camera.
        quality: Its columns and rows.
        scale: Further pixels for each, along columns and along rows.
    """
    camera = sensor.rig.camera
    columns, rows = scale * quality.columns, scale * quality.rows
    x, y = camera.principal_offset_px
    offset = (x * columns / camera.columns, y * rows / camera.rows)
    update = {"columns": columns, "rows": rows, "principal_offset_px": offset, "region_px": None}
    return camera.model_copy(update=update)


def render_of(sensor: SweptSensor, quality: Quality) -> RenderSettings:
    """The sensor's rendering at the quality's samples and particles."""
    names = ("samples", "particles", "anchor_samples", "anchor_particles")
    return sensor.render.model_copy(update={name: getattr(quality, name) for name in names})
