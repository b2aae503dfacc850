import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import OBJECT_KINDS, parse_object
from magicsim.geometry.objects.textured import DotPlate, Plate, RidgePlate
from magicsim.geometry.shapes.entry import EntrySide
from magicsim.geometry.shapes.revolved import cone, domed_cylinder
from magicsim.geometry.shapes.solids import RoundedBox, RoundedCylinder, Sphere

UP = (0.0, 0.0, 1.0)
PLATE = Plate(size_mm=6.0, thickness_mm=2.0, edge_radius_mm=0.1)
MINIMAL = {
    "sphere": "radius_mm=1",
    "cylinder": "radius_mm=1",
    "punch": "radius_mm=1",
    "box": "size_mm=1",
    "domed_cylinder": "radius_mm=1",
    "cone": "half_angle_deg=30",
    "dots": "radius_mm=0.2,spacing_mm=0.6",
    "lines": "width_mm=0.2,spacing_mm=0.5",
    "spanner": "jaw_mm=8",
    "screwdriver": "radius_mm=9",
    "scissors": "tube_radius_mm=3",
    "banana": "radius_mm=15",
    "plug": "radius_mm=5",
    "mesh": "path=part.stl",
}
"""What has to be given of each kind."""


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("sphere:radius_mm=4", Sphere(4.0)),
        ("cylinder:radius_mm=2,length_mm=9,axis=x", EntrySide(RoundedCylinder(2.0, 9.0, "x", 0.1), UP, 0.05, 0.5)),
        ("cylinder:radius_mm=2", EntrySide(RoundedCylinder(2.0, 20.0, "y", 0.1), UP, 0.05, 0.5)),
        ("punch:radius_mm=3,edge_radius_mm=0.5", EntrySide(RoundedCylinder(3.0, 10.0, "z", 0.5), UP, 0.05, 0.5)),
        ("punch:radius_mm=0.12", EntrySide(RoundedCylinder(0.12, 10.0, "z", 0.1), UP, 0.03, 0.24)),
        ("box:size_mm=4x5x8", EntrySide(RoundedBox((4.0, 5.0, 8.0), 0.1), UP, 0.05, 0.5)),
        ("box:size_mm=[4, 5,8],edge_radius_mm=0.1", EntrySide(RoundedBox((4.0, 5.0, 8.0), 0.1), UP, 0.05, 0.5)),
        ("box:size_mm=[4,5,8]", EntrySide(RoundedBox((4.0, 5.0, 8.0), 0.1), UP, 0.05, 0.5)),
        ("box:size_mm=4", EntrySide(RoundedBox((4.0, 4.0, 4.0), 0.1), UP, 0.05, 0.5)),
        ("domed_cylinder:radius_mm=2,length_mm=8", EntrySide(domed_cylinder(2.0, 8.0, 0.1), UP, 0.5, 0.5)),
        (
            "cone:half_angle_deg=30",
            EntrySide(cone(30.0, 5.0, tip_radius_mm=0.05, flat_radius_mm=0.0, edge_radius_mm=0.02), UP, 0.025, 0.5),
        ),
        (
            "cone:half_angle_deg=17.5,length_mm=3,flat_radius_mm=0.395",
            EntrySide(cone(17.5, 3.0, tip_radius_mm=0.05, flat_radius_mm=0.395, edge_radius_mm=0.02), UP, 0.05, 0.5),
        ),
        (
            "dots:radius_mm=0.1,spacing_mm=0.6",
            EntrySide(DotPlate(radius_mm=0.1, spacing_mm=0.6, plate=PLATE), UP, 0.025, 0.2),
        ),
        (
            "lines:width_mm=0.2,spacing_mm=0.6,height_mm=0.4",
            EntrySide(
                RidgePlate(width_mm=0.2, spacing_mm=0.6, height_mm=0.4, edge_radius_mm=0.05, plate=PLATE),
                UP,
                0.025,
                0.2,
            ),
        ),
    ],
)
def test_every_kind_is_read_into_its_shape(text: str, shape: object):
    assert parse_object(text).shape() == shape


def test_every_kind_is_covered_by_the_line_format():
    assert MINIMAL.keys() == OBJECT_KINDS.keys()
    for kind, model in OBJECT_KINDS.items():
        assert type(parse_object(f"{kind}:{MINIMAL[kind]}")) is model


@pytest.mark.parametrize("kind", sorted(MINIMAL))
def test_kind_without_what_it_needs_says_what_is_missing(kind: str):
    name = MINIMAL[kind].partition("=")[0]
    with pytest.raises(ConfigError, match=f"{name} is missing"):
        parse_object(kind)


def test_side_of_entry_follows_roll_and_pitch_but_not_yaw():
    turned = parse_object("box:size_mm=4,roll_deg=90,yaw_deg=30").shape()
    assert isinstance(turned, EntrySide)
    assert turned.up == pytest.approx((0, 1, 0), abs=1e-15)
    pitched = parse_object("punch:radius_mm=1,pitch_deg=30").shape()
    assert isinstance(pitched, EntrySide)
    assert pitched.up == pytest.approx((-0.5, 0, 3**0.5 / 2))


def test_mesh_is_not_read_before_its_shape_is_asked_for():
    thing = parse_object("mesh:path=no-such-part.stl,scale=25.4,feature_mm=0.3")
    with pytest.raises(ConfigError, match=r"mesh 'no-such-part.stl' does not exist"):
        thing.shape()


@pytest.mark.parametrize("name", ["a,b.stl", "a,,b c=2.stl", "a#%'.stl", "ü:\\x.stl"])
def test_name_of_a_mesh_may_have_any_sign(name: str):
    assert parse_object(f"mesh:scale=2,path={name},roll_deg=3").path == name
    assert parse_object(f"mesh:path={name}").path == name


def test_colour_and_orientation_are_read_beside_the_shape():
    thing = parse_object("sphere:radius_mm=4, color=0.1x0.2x0.3, roll_deg=-5")
    assert thing.color == (0.1, 0.2, 0.3)
    assert thing.roll_deg == -5


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "unknown object kind ''"),
        (
            "sphre:radius_mm=4",
            "did you mean 'sphere'?); available: banana, box, cone, cylinder, domed_cylinder, dots, lines, mesh,",
        ),
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
        (
            "box:size=2",
            "available: color, edge_radius_mm, kind, pitch_deg, roll_deg, roughness, size_mm, specular, yaw_deg",
        ),
        ("cylinder:radius_mm=2,axis=w", "axis = 'w' is not allowed: must be 'x', 'y' or 'z'"),
        ("cylinder:radius_mm=2,length_mm=0.1", "edge_radius_mm = 0.1"),
        ("punch:radius_mm=3,edge_radius_mm=3", "edge_radius_mm = 3 is not allowed: must be below 3 mm"),
        (
            "domed_cylinder:radius_mm=3,length_mm=3",
            "length_mm = 3 is not allowed: must be at least radius and rim, 3.1",
        ),
        ("domed_cylinder:radius_mm=0.1", "edge_radius_mm = 0.1 is not allowed: must be below 0.1 mm"),
        ("cone:half_angle_deg=0", "half_angle_deg = '0'"),
        ("cone:half_angle_deg=90", "half_angle_deg = '90'"),
        ("cone:half_angle_deg=30,tip_radius_mm=0.001", "tip_radius_mm = '0.001'"),
        ("cone:half_angle_deg=30,flat_radius_mm=-1", "flat_radius_mm = '-1'"),
        (
            "cone:half_angle_deg=30,flat_radius_mm=0.01",
            "flat_radius_mm = 0.01 is not allowed: must be 0 or above 0.01155",
        ),
        ("cone:half_angle_deg=30,tip_radius_mm=6", "length_mm = 5 is not allowed: must be above tip and rim, 6.03 mm"),
        ("cone:half_angle_deg=89", "must be 0.02 to 200 mm"),
        ("dots:radius_mm=0.2,spacing_mm=0.4", "spacing_mm = 0.4 is not allowed: must be above 2 radius_mm = 0.4"),
        ("dots:radius_mm=3,spacing_mm=7", "size_mm = 6 is not allowed: one dot needs 6 mm of the 5.8 mm that are flat"),
        ("dots:radius_mm=0.02,spacing_mm=0.05", "dots are too many: at most 2500"),
        ("lines:width_mm=0.4,spacing_mm=0.4", "spacing_mm = 0.4 is not allowed: must be above width_mm = 0.4"),
        ("lines:width_mm=6,spacing_mm=7", "one ridge needs 6 mm of the 5.8 mm that are flat"),
        (
            "lines:width_mm=0.4,spacing_mm=1,edge_radius_mm=0.3",
            "edge_radius_mm = 0.3 is not allowed: must be at most 0.2",
        ),
        ("lines:width_mm=0.4,spacing_mm=1,height_mm=0.1,edge_radius_mm=0.1", "must be at most 0.05 mm"),
        ("lines:width_mm=0.011,spacing_mm=0.02", "290 ridges are too many: at most 200"),
        ("mesh:path=a.stl,scale=0", "scale = '0'"),
    ],
)
def test_bad_object_is_refused_in_one_line_that_names_it(text: str, named: str):
    with pytest.raises(ConfigError) as caught:
        parse_object(text)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)
