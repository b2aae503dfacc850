"""The results of an evaluation as files, as lines for people, and as JUnit's XML, which build servers read."""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import tomli_w
from markupsafe import Markup

from magicsim import frame_class as truth
from magicsim.detectors.verdict import FEATURES, REPEATABILITY_SD
from magicsim.evaluation.evaluate import Evaluation
from magicsim.evaluation.pictures import changed_sheet, plot_detection, plot_roc, sheet
from magicsim.evaluation.rest import Rest
from magicsim.evaluation.suite import SuiteConfig
from magicsim.folder import MARKER, SIGNATURE, result_file, result_folder
from magicsim.judge.changed_frames import FrameRun
from magicsim.judge.curves import CurvePoint
from magicsim.judge.measures import COMPUTE, SHARE, TABLE, MeasureEstimate
from magicsim.judge.regression import Change
from magicsim.judge.tally import SIMULATED
from magicsim.notebook.screen import STRONGER
from magicsim.report.text import MINUS, MISSING, number, page_template, percent, span

RESULTS = "evaluation.json"
REPORT = "report.html"
COLUMNS = {name: kind.column for name, kind in TABLE.items() if kind.column}
"""Measures of the table of groups."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangeRow:
    """A compared measure as the page shows it."""

    title: str
    condition: str
    baseline: str
    current: str
    p: str
    smallest: str
    is_tested: bool
    verdict: str
    frames: list[FrameRun]


def write_results(result: Evaluation, suite: SuiteConfig, out: Path) -> Path:
    """Writes the folder of results and returns its report."""
    with result_folder(out) as folder:
        (folder / RESULTS).write_text(json.dumps(result.as_dict(), allow_nan=False, indent=1) + "\n", encoding="utf-8")
        (folder / REPORT).write_text(render_page(result), encoding="utf-8")
        resolved = tomli_w.dumps(suite.model_dump(mode="json", exclude_none=True))
        (folder / MARKER).write_text(f"{SIGNATURE}\n{resolved}", encoding="utf-8")
    return out / REPORT


def render_page(result: Evaluation) -> str:
    """The report as one HTML page that needs nothing else."""
    facts = result.as_dict()
    standard = [each for each in result.changes if each.condition == result.standard]
    smallest = {each.measure: change_row(each).smallest for each in standard}
    worse = [run for each in result.regressions for run in each.frames]
    return page_template("evaluation.html.jinja", "magicsim.evaluation", "magicsim.report").render(
        title=f"Detector “{result.detector}” on the suite “{result.suite}”",
        facts={
            "Episodes": f"{facts['episodes']} ({len({each.tag.take for each in result.episodes})} takes)",
            "Frames": str(facts["frames"]),
            "Sensors": ", ".join(dict.fromkeys(each.tag.sensor for each in result.episodes)),
            "Standard condition": f"{result.standard} (light while the object is there / sensor noise)",
            "Baseline": result.baseline or "none",
            "Time of one step": f"{facts['milliseconds_per_frame']:.1f} ms, on the machine that ran this",
        } | ({"Not judged": result.not_judged} if result.not_judged else {}),
        columns=COLUMNS,
        groups={
            group: [value_text(name, row[name]) for name in COLUMNS] for group, row in result.metrics.items()
        },
        details=[(TABLE[name], value_text(name, result.metrics[result.standard][name]), smallest.get(name, MISSING))
                 for name in COMPUTE],
        table=TABLE.values(),
        faultless=share_of_episodes(result.metrics[result.standard]["faultless_episodes"]),
        confusion=result.confusion,
        right={"Clear": {"Normal", "Untouched", "Unknown"}, "Near": {"Approaching", "Untouched", "Unknown"},
               "Light": {"Noise", "Untouched", "Unknown"}, "Contact": {"Touched"}},
        roc=Markup(plot_roc(result.roc, name="roc")),
        distance=_drawn(result.distance, "distance", "gap [mm]", (truth.NEAR_MIN_MM, truth.NEAR_MAX_MM)),
        depth=_drawn(result.depth, "depth", "depth [mm]",
                     (truth.CONTACT_MIN_DEPTH_MM, max((each.to_mm for each in result.depth), default=0.0))),
        collapses=collapse_lines(result),
        cannot_judge=result.cannot_judge,
        moved=moved_lines(result),
        compared=[change_row(each) for each in result.changes],
        pictures=sheet(result.footage, result.episodes, result.standard),
        changed=changed_sheet(result.footage, result.episodes, worse),
        rest=rest_rows(result.rest),
        features=feature_rows(result.rest),
        repeatability=f"{REPEATABILITY_SD:g}",
        truth=truth,
        stronger=STRONGER,
        span=span,
    )  # fmt: skip


def describe(result: Evaluation) -> list[str]:
    """Results as lines for people."""
    lines = [
        f"{result.detector} on {result.suite}: {len(result.episodes)} episodes, standard condition {result.standard}"
    ]
    sensors = Counter(each.tag.sensor for each in result.episodes)
    if set(sensors) != {SIMULATED}:
        lines.append(f"  sensors: {', '.join(f'{name} ({count} episodes)' for name, count in sensors.items())}")
    for group, values in result.metrics.items():
        parts = [f"{COLUMNS[name]} {value_text(name, values[name])}" for name in list(COLUMNS)[:2]]
        lines.append(f"  {group}: {', '.join(parts)}")
    lines += [f"  {line}" for line in rest_lines(result.rest)]
    lines += [f"not judged: {result.not_judged}"] if result.not_judged else []
    for each in (*result.regressions, *result.improvements):
        row = change_row(each)
        chance = f", p = {row.p}" if row.is_tested else ""
        lines.append(f"{row.verdict}: {row.title} ({row.condition}) {row.baseline} -> {row.current}{chance}")
        lines += [f"  {line}" for line in frame_lines(each)]
    lines += collapse_lines(result)
    lines += moved_lines(result)
    for condition in dict.fromkeys(each.condition for each in result.changes):
        parts = [
            f"{COLUMNS[each.measure]} {change_row(each).smallest}"
            for each in result.changes
            if each.condition == condition and each.measure in COLUMNS
        ]
        lines.append(f"smallest falls that could be found, {condition}: {', '.join(parts)}")
    if result.baseline is None:
        lines.append("compared with no baseline (--baseline, --save-baseline)")
    elif not result.is_worse:
        weak = f"cannot judge: {result.cannot_judge}" if result.cannot_judge else ""
        lines.append(weak or f"no regression against {result.baseline}")
    return lines


def frame_lines(change: Change) -> list[str]:
    """The frames behind a change as lines for people."""
    return [
        f"{run.episode} {span(run.first, run.last)}: {run.truth}, {run.baseline} -> {run.current}"
        for run in change.frames
    ]


def moved_lines(result: Evaluation) -> list[str]:
    """Whether the frames or the verdicts changed as lines for people, and what fell on frames that are others now."""
    if result.beside is None:
        return []
    fallen = [change_row(each) for each in result.beside.moved if each.is_regression]
    return [
        *result.beside.lines,
        *(f"  on the changed frames: {row.title} ({row.condition}) {row.baseline} -> {row.current}" for row in fallen),
    ]


def collapse_lines(result: Evaluation) -> list[str]:
    """What collapsed as lines for people."""
    known = f", as of the baseline {result.baseline}"
    return [f"collapse: {result.detector}: {each.says}{known if each.is_known else ''}" for each in result.collapses]


def rest_lines(rests: Sequence[Rest]) -> list[str]:
    """Streams at rest as lines for people."""
    lines = []
    for each in rests:
        margins = [
            f"{name} {score.margin_sd:.1f} sd from rest, {score.weak_verdicts} of {score.verdicts} right ones on less "
            f"than {REPEATABILITY_SD:g} sd"
            for name, score in (("Touched", each.touch), ("Approaching", each.approach))
            if score is not None
        ]
        alarms = f"{each.alarms} false alarms in {each.frames} untouched frames"
        hourly = f"{number(each.low, 1)} to {number(each.high, 1)} an hour"
        lines.append(f"at rest, {each.place}/{each.noise}: {'; '.join([f'{alarms} ({hourly})', *margins])}")
        measures = [f"{row[1]} {row[2]} (touch {row[3]}, near {row[4]} sd)" for row in feature_rows([each])]
        lines += [f"at rest, {each.place}/{each.noise}: {', '.join(measures)}"] if measures else []
    return lines


def rest_rows(rests: Sequence[Rest]) -> list[list[str]]:
    """Streams at rest as the rows of a table, see the page's head."""
    rows = []
    for each in rests:
        expected = MISSING if each.expected_per_hour is None else f"{each.expected_per_hour:.2g}"
        row = [f"{each.place}, {each.noise}", str(each.frames), str(each.alarms)]
        row += [f"{number(each.low, 1)} to {number(each.high, 1)}", expected]
        for score in (each.touch, each.approach):
            weak = MISSING if score is None else f"{score.weak_verdicts} of {score.verdicts}"
            row += [MISSING if score is None else number(score.margin_sd, 1), weak]
        rows.append(row)
    return rows


def feature_rows(rests: Sequence[Rest]) -> list[list[str]]:
    """E, C and S at rest and their distances of touch and approach as the rows of a table, see the page's head."""
    return [
        [
            f"{each.place}, {each.noise}", FEATURES[name], f"{number(rest.mean, 3)} ± {rest.sd:.2g}",
            *(MISSING if d is None else f"{d:+.1f}".replace("-", MINUS) for d in (rest.touch_d, rest.approach_d)),
        ]
        for each in rests
        for name, rest in each.features.items()
    ]  # fmt: skip


def value_text(name: str, each: MeasureEstimate) -> str:
    """A measure with its interval."""
    if each.value is None:
        return MISSING
    is_share = TABLE[name].unit == SHARE
    value, scale, digits = (percent(each.value), 100, 1) if is_share else (number(each.value, 3), 1, 3)
    ends = [number(scale * end, digits) for end in (each.low, each.high) if end is not None]
    return f"{value} ({ends[0]} to {ends[1]})" if ends else value


def share_of_episodes(each: MeasureEstimate) -> str:
    """How many episodes are free of mistakes, with the exact interval."""
    if each.value is None or each.low is None or each.high is None:
        return MISSING
    right = round(each.value * each.episodes)
    return f"{right} of {each.episodes} episodes (95 % interval {percent(each.low, 0)} to {percent(each.high, 0)})"


def change_row(each: Change) -> ChangeRow:
    """A compared measure as text."""
    p = each.p_fall_corrected if each.fall > 0 else each.p_rise_corrected
    show = percent if TABLE[each.measure].unit == SHARE else (lambda value: number(value, 3))
    return ChangeRow(
        title=TABLE[each.measure].title,
        condition=each.condition,
        baseline=show(each.baseline),
        current=show(each.current),
        p=MISSING if p is None else f"{p:.3g}",
        smallest="none" if each.smallest_fall is None else show(each.smallest_fall),
        is_tested=p is not None,
        verdict="regression" if each.is_regression else "improvement" if each.is_improvement else "no change",
        frames=each.frames,
    )


def _drawn(points: Sequence[CurvePoint], which: str, axis: str, scored_mm: tuple[float, float]) -> Markup | None:
    label = f"Detection rate against {which}"
    drawn = plot_detection(points, axis=axis, name=which, scored_mm=scored_mm, label=label) if points else None
    return Markup(drawn) if drawn is not None else None


def junit(result: Evaluation) -> ElementTree.ElementTree:
    """Failures are measures that fell and classes that collapsed; an error is that nothing could be judged."""
    suite = ElementTree.Element("testsuite", name=f"{result.detector} on {result.suite}")
    for each in result.changes:
        row = change_row(each)
        case = _case(suite, each.condition, row.title)
        told = ElementTree.SubElement(case, "properties")
        for name, value in (("meaning", TABLE[each.measure].meaning), ("smallest fall to be found", row.smallest)):
            ElementTree.SubElement(told, "property", name=name, value=value)
        if each.is_regression:
            message = f"{row.baseline} -> {row.current}" + (f", p = {row.p}" if row.is_tested else "")
            ElementTree.SubElement(case, "failure", message=message).text = "\n".join(frame_lines(each))
    for collapse in result.collapses:
        case = _case(suite, result.standard, f"collapse of {collapse.of}")
        if not collapse.is_known:
            ElementTree.SubElement(case, "failure", message=collapse.says)
    case = _case(suite, result.standard, "a fall could have been found")
    if result.cannot_judge:
        ElementTree.SubElement(case, "error", message=f"cannot judge: {result.cannot_judge}")
    ElementTree.SubElement(suite, "system-out").text = "\n".join(moved_lines(result))
    for name, kind in (("tests", "testcase"), ("failures", "failure"), ("errors", "error")):
        suite.set(name, str(len(list(suite.iter(kind)))))
    suite.set("time", f"{result.seconds:.3f}")
    return ElementTree.ElementTree(suite)


def write_junit(result: Evaluation, path: Path) -> None:
    """Writes the XML; the file appears whole or not at all."""
    with result_file(path) as partial:
        junit(result).write(partial, encoding="utf-8", xml_declaration=True)


def _case(suite: ElementTree.Element, condition: str, name: str) -> ElementTree.Element:
    return ElementTree.SubElement(suite, "testcase", classname=condition, name=name)
