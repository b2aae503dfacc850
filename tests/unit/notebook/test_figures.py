from xml.etree import ElementTree

import pytest

from magicsim.notebook import curve, figures_table


def test_table_escapes_names_and_rounds_numbers():
    table = figures_table("a < b", {"force [N]": 1.23456, "is <it>": True})
    assert "a &lt; b" in table
    assert ">1.235<" in table
    assert "is &lt;it&gt;" in table
    ElementTree.fromstring(table)


@pytest.mark.parametrize("values", [(0.0, 1.0, 4.0), (0.0, 0.0, 0.0), (-1.0, 0.0, 2.0)])
def test_curve_is_svg_with_a_dot_a_point_inside_its_frame(values):
    root = ElementTree.fromstring(curve((0.0, 0.5, 1.0), values, x_label="depth [mm]", y_label="force [N]"))
    dots = root.findall("{http://www.w3.org/2000/svg}circle")
    assert len(dots) == 3
    assert all(0 <= float(dot.get("cx")) <= 360 for dot in dots)
    assert all(0 <= float(dot.get("cy")) <= 200 for dot in dots)
    heights = [float(dot.get("cy")) for dot in dots]
    assert heights == sorted(heights, reverse=True)  # up is up
