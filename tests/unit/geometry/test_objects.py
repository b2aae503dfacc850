import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.objects import OBJECT_KINDS, parse_object
from magicsim.geometry.shapes import RoundedBox, RoundedCylinder, Sphere


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("sphere:radius_mm=4", Sphere(4.0)),
        ("cylinder:radius_mm=2,length_mm=9,axis=x", RoundedCylinder(2.0, 9.0, "x", 0.1)),
        ("cylinder:radius_mm=2", RoundedCylinder(2.0, 20.0, "y", 0.1)),
        ("punch:radius_mm=3,edge_radius_mm=0.5", RoundedCylinder(3.0, 10.0, "z", 0.5)),
        ("box:size_mm=4x5x8", RoundedBox((4.0, 5.0, 8.0), 0.1)),
        ("box:size_mm=4", RoundedBox((4.0, 4.0, 4.0), 0.1)),
    ],
)
def test_every_kind_is_read_into_its_shape(text: str, shape: object):
    assert parse_object(text).shape() == shape


def test_every_kind_is_covered_by_the_line_format():
    for kind, model in OBJECT_KINDS.items():
        size = "size_mm" if "size_mm" in model.model_fields else "radius_mm"
        assert type(parse_object(f"{kind}:{size}=1")) is model


def test_colour_and_orientation_are_read_beside_the_shape():
    thing = parse_object("sphere:radius_mm=4, color=0.1x0.2x0.3, roll_deg=-5")
    assert thing.color == (0.1, 0.2, 0.3)
    assert thing.roll_deg == -5


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "unknown object kind ''"),
        ("sphre:radius_mm=4", "did you mean 'sphere'?); available: box, cylinder, punch, sphere"),
        ("sphere", "radius_mm is missing"),
        ("sphere:radius_mm", "'radius_mm' is not of the form key=value"),
        ("sphere:radius_mm=", "radius_mm = ''"),
        ("sphere:radius_mm=big", "radius_mm = 'big'"),
        ("sphere:radius_mm=nan", "radius_mm = 'nan'"),
        ("sphere:radius_mm=inf", "radius_mm = 'inf'"),
        ("sphere:radius_mm=-1", "radius_mm = '-1'"),
        ("sphere:radius_mm=0", "radius_mm = '0'"),
        ("sphere:radius_mm=1000", "radius_mm = '1000'"),
        ("sphere:radius=4", "unknown key 'radius' (did you mean 'radius_mm'?)"),
        ("sphere:radius_mm=4,kind=box", "kind = 'box'"),
        ("sphere:radius_mm=4,color=2x0x0", "color.0 = '2'"),
        ("sphere:radius_mm=4,color=0.5", "color = '0.5'"),
        ("box:size_mm=4x4", "size_mm = ['4', '4']"),
        ("box:size_mm=4x4xa", "size_mm"),
        ("box:size_mm=0.2", "edge_radius_mm = 0.1 is not allowed: must be below 0.1 mm"),
        ("box:size=2", "available: color, edge_radius_mm, kind, pitch_deg, roll_deg, size_mm, yaw_deg"),
        ("cylinder:radius_mm=2,axis=w", "axis = 'w' is not allowed: must be 'x', 'y' or 'z'"),
        ("cylinder:radius_mm=2,length_mm=0.1", "edge_radius_mm = 0.1"),
        ("punch:radius_mm=3,edge_radius_mm=3", "edge_radius_mm = 3 is not allowed: must be below 3 mm"),
    ],
)
def test_bad_object_is_refused_in_one_line_that_names_it(text: str, named: str):
    with pytest.raises(ConfigError) as caught:
        parse_object(text)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)
