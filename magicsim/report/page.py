"""The report of an episode as one HTML page that needs nothing else: no network, no script, no files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from magicsim import frame_class as truth
from magicsim.detectors.verdict import Verdict
from magicsim.errors import ConfigError
from magicsim.judge.verdicts import Judgement
from magicsim.report.contact_sheet import Caption, pick_frames, write_caption
from magicsim.report.facts import scene_facts
from magicsim.report.images import data_uri
from magicsim.report.mistakes import Mistake, list_mistakes
from magicsim.report.palette import CLASS_COLORS
from magicsim.report.plots import plot_features, plot_force_depth, plot_forces
from magicsim.report.story import tell_phases
from magicsim.report.tables.rest_table import RestRow, rest_rows
from magicsim.report.tables.score_table import ScoreTable, contact_table, proximity_table
from magicsim.report.tables.solve_table import solve_rows
from magicsim.report.templates import page_template
from magicsim.report.text import span
from magicsim.simulation.episode import Episode, SimulatedFrame

SHEET_PROFILE = "calibrated"
"""Profile whose verdicts stand on the contact sheet; where it is missing, the last one judged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProfilePart:
    """What the page says about one profile."""

    profile: str
    plot: Markup | None
    tables: tuple[ScoreTable, ...]
    """Proximity and contact."""
    mistakes: tuple[Mistake, ...]
    parts: list[str]
    """Parts of the story, for the rows of `rest`."""
    rest: list[RestRow]


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """One picture of the contact sheet."""

    picture: str
    """Data URI."""
    caption: Caption


def render_report(episode: Episode, judgements: Sequence[Judgement], facts: Mapping[str, str]) -> str:
    """Write the report of an episode.

    Args:
        episode: The frames and their truth.
        judgements: Verdicts of one or more profiles on the scored frames; may be empty.
        facts: Further facts for the head of the page, by name; one of the same name replaces the scene's own
            (`Design`, `Rig`, `Object`, `Seed`, `Frames`). `Scene`, where given, is the name in the title.

    Returns:
        A whole HTML document.

    Raises:
        ConfigError: A judgement has another number of verdicts than the episode has scored frames.
    """
    frames = episode.scored
    for each in judgements:
        if len(each.verdicts) != len(frames):
            msg = (
                f"judgement '{each.profile}' has {len(each.verdicts)} verdicts "
                f"for {len(frames)} scored frames; must be one for each"
            )
            raise ConfigError(msg)
    sheet = _sheet_judgement(judgements)
    touched = any(frame.truth.contact for frame in frames)
    approached = any(frame.truth.state.has_object for frame in frames)
    template = page_template("report.html.jinja", "magicsim.report")
    return template.render(
        title=f"Simulated episode: {facts['Scene']}" if "Scene" in facts else "Simulated episode",
        facts={name: value for name, value in {**scene_facts(episode), **facts}.items() if name != "Scene"},
        profiles=[_profile_part(frames, each, place) for place, each in enumerate(judgements, start=1)],
        sheet_profile=sheet.profile if sheet else None,
        cards=_cards(frames, sheet.verdicts if sheet else None),
        class_colors={str(each): color for each, color in CLASS_COLORS.items()},
        forces=Markup(plot_forces(frames, name="forces")) if approached else None,
        force_depth=Markup(plot_force_depth(frames, name="force-depth")) if touched else None,
        solve=solve_rows(frames),
        truth=truth,
        span=span,
    )


def _sheet_judgement(judgements: Sequence[Judgement]) -> Judgement | None:
    named = [each for each in judgements if each.profile == SHEET_PROFILE]
    return next(iter([*named, *reversed(judgements)]), None)


def _cards(frames: Sequence[SimulatedFrame], verdicts: Sequence[Verdict] | None) -> list[Card]:
    phases = tell_phases(frames)
    return [
        Card(
            picture=data_uri(frames[place].image),
            caption=write_caption(frames[place], phases[place], verdicts[place] if verdicts else None),
        )
        for place in pick_frames(frames)
    ]


def _profile_part(frames: Sequence[SimulatedFrame], judgement: Judgement, place: int) -> ProfilePart:
    parts, rest = rest_rows(frames, judgement)
    return ProfilePart(
        parts=parts,
        rest=rest,
        profile=judgement.profile,
        plot=Markup(plot_features(frames, judgement, name=f"features-{place}")) if frames else None,
        tables=(proximity_table(judgement.score), contact_table(judgement.score)),
        mistakes=tuple(list_mistakes(frames, judgement.verdicts)),
    )
