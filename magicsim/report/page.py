"""The report of an episode as one HTML page that needs nothing else: no network, no script, no files."""

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from magicsim import frame_class as truth
from magicsim.detectors.verdict import Verdict
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.judge.verdicts import Judgement
from magicsim.notebook.screen import STRONGER
from magicsim.report import tables
from magicsim.report.drawing import CLASS_COLORS
from magicsim.report.plots import plot_features, plot_force_depth, plot_forces
from magicsim.report.text import MINUS, data_uri, page_template, short_name, span
from magicsim.scenes.rig import Rig
from magicsim.simulation.episode import Episode, SimulatedFrame

_UNITS = {"mm": " mm", "deg": "\u00b0"}


def scene_facts(episode: Episode) -> Mapping[str, str]:
    """Design, rig, object, seed and number of frames; files by their last name."""
    scene = episode.scene
    return {
        "Design": describe_design(scene.design),
        "Rig": describe_rig(scene.rig),
        "Object": describe_object(scene.object) if scene.object else "none",
        "Seed": str(scene.seed),
        "Frames": f"{len(episode.references)} references, {len(episode.scored)} scored, "
        f"{scene.frames_per_second:g} per second",
    }


def describe_design(design: ElastomerDesign) -> str:
    """Size of a block, and its skin and cells [mm]."""
    grid = f"cell {design.cell_mm:g} mm, wall {design.wall_mm:g} mm" if design.has_grid else "no grid"
    width, length = design.footprint_mm
    return f"{width:g} x {length:g} x {design.height_mm:g} mm, skin {design.skin_mm:g} mm, {grid}"


def describe_rig(rig: Rig) -> str:
    """Lights and picture of a rig, with the sides that carry a light."""
    names = ", ".join(strip.side.replace("-", MINUS) for strip in rig.strips)
    sides = f"LED strips at {names}" if rig.strips else "no LED strips"
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


SHEET_PROFILE = "calibrated"
"""Profile whose verdicts stand on the contact sheet; where it is missing, the last one judged."""


def render_report(episode: Episode, judgements: Sequence[Judgement], facts: Mapping[str, str]) -> str:
    """The report of an episode as a whole HTML document, with verdicts of any number of profiles.

    Facts are added to the scene's own at the head of the page.
    """
    frames = episode.scored
    sheet = next((each for each in judgements if each.profile == SHEET_PROFILE), judgements[-1] if judgements else None)
    touched = any(frame.truth.contact for frame in frames)
    approached = any(frame.truth.state.has_object for frame in frames)
    return page_template("report.html.jinja", "magicsim.report").render(
        title="Simulated episode",
        facts={**scene_facts(episode), **facts},
        profiles=[_profile_part(frames, each, place) for place, each in enumerate(judgements, start=1)],
        sheet_profile=sheet.profile if sheet else None,
        cards=_cards(episode, sheet.verdicts if sheet else None),
        class_colors={str(each): color for each, color in CLASS_COLORS.items()},
        forces=Markup(plot_forces(frames, name="forces")) if approached else None,
        force_depth=Markup(plot_force_depth(frames, name="force-depth")) if touched else None,
        solve=tables.solve_rows(frames),
        truth=truth,
        stronger=STRONGER if episode.references else None,
        span=span,
    )


def _cards(episode: Episode, verdicts: Sequence[Verdict] | None) -> list[dict[str, Any]]:
    """Frames of the contact sheet beside their changes."""
    frames = episode.scored
    phases, places = tables.tell_phases(frames), tables.pick_frames(frames)
    return [
        {
            "picture": data_uri(picture),
            "phase": str(phases[place]),
            "caption": tables.write_caption(frames[place], verdicts[place] if verdicts else None),
        }
        for place, picture in zip(places, episode.on_screen([frames[place] for place in places]), strict=True)
    ]


def _profile_part(frames: Sequence[SimulatedFrame], judgement: Judgement, place: int) -> dict[str, Any]:
    """What the page says about one profile; `parts` are those of the story, for the rows of `rest`."""
    parts, rest = tables.rest_rows(frames, judgement)
    return {
        "profile": judgement.profile, "parts": parts, "rest": rest,
        "plot": Markup(plot_features(frames, judgement, name=f"features-{place}")) if frames else None,
        "tables": (tables.proximity_table(judgement.score), tables.contact_table(judgement.score)),
        "mistakes": tables.list_mistakes(frames, judgement.verdicts),
    }  # fmt: skip
