"""The results of an evaluation as JUnit's XML, which build servers read: one test case for each compared measure."""

from pathlib import Path
from xml.etree import ElementTree

from magicsim.evaluation.evaluate import Evaluation
from magicsim.evaluation.page import change_row, moved_lines
from magicsim.folder import result_file
from magicsim.judge.measures import TABLE
from magicsim.report.text import span


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
            frames = [
                f"{run.episode} {span(run.first, run.last)}: {run.truth}, {run.baseline} -> {run.current}"
                for run in each.frames
            ]
            message = f"{row.baseline} -> {row.current}" + (f", p = {row.p}" if row.is_tested else "")
            ElementTree.SubElement(case, "failure", message=message).text = "\n".join(frames)
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
