"""What a scene says about itself, for the head of a page."""

from collections.abc import Mapping

from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.report.text import MINUS, short_name
from magicsim.scenes.rig import Rig
from magicsim.simulation.episode import Episode

_UNITS = {"mm": " mm", "deg": "\u00b0"}


def scene_facts(episode: Episode) -> Mapping[str, str]:
    """Design, rig, object, seed and number of frames; files by their last name."""
    scene = episode.scene
    return {
        "Design": describe_design(scene.design),
        "Rig": describe_rig(scene.rig),
        "Object": describe_object(scene.object) if scene.object else "none",
        "Seed": str(scene.seed),
        "Frames": (
            f"{len(episode.references)} references, {len(episode.scored)} scored, "
            f"{scene.frames_per_second:g} per second"
        ),
    }


def describe_design(design: ElastomerDesign) -> str:
    """Size of a block, and its skin and cells [mm]."""
    size = _value((*design.footprint_mm, design.height_mm))
    if not design.has_grid:
        return f"{size} mm, no grid"
    return f"{size} mm, skin {design.skin_mm:g} mm, cells {design.cell_mm:g} mm, walls {design.wall_mm:g} mm"


def describe_rig(rig: Rig) -> str:
    """Lights and picture of a rig, with the sides that carry a light."""
    sides = (
        f"LED strips at {', '.join(strip.side.replace('-', MINUS) for strip in rig.strips)}"
        if rig.strips
        else "no LED strips"
    )
    if rig.leds:
        sides += f"; {len(rig.leds)} single LEDs"
    if rig.ring is not None:
        sides += f"; a ring of {rig.ring.leds} LEDs" if rig.ring.leds else "; an even ring"
    return f"{sides}; {rig.camera.columns} \u00d7 {rig.camera.rows} px"


def describe_object(config: ObjectConfig) -> str:
    """The kind of an object and everything about its shape that differs from the default."""
    values = config.model_dump(exclude_defaults=True, exclude={"kind", "color"})
    details = ", ".join(_detail(name, value) for name, value in values.items())
    return f"{config.kind}: {details}" if details else config.kind


def _detail(name: str, value: object) -> str:
    stem, _, unit = name.rpartition("_")
    if unit in _UNITS:
        return f"{stem.replace('_', ' ')} {_value(value)}{_UNITS[unit]}"
    return f"{name.replace('_', ' ')} {_value(value)}"


def _value(value: object) -> str:
    if isinstance(value, float):
        return f"{round(value, 9):g}"
    if isinstance(value, tuple | list):
        return " \u00d7 ".join(_value(each) for each in value)
    return short_name(str(value))
