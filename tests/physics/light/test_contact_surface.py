"""The rendered skin and the object: no visible penetration, and a film of air only where it is asked for."""

import numpy as np
import pytest

from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor


def facet_points(vertices, faces):
    """Points spread over every triangle, shape (points, 3)."""
    weights = np.array([[1, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [1 / 3, 1 / 3, 1 / 3]])
    return np.einsum("wc,tci->twi", weights, vertices[faces]).reshape(-1, 3)


@pytest.mark.parametrize(("coupling", "low", "high"), [("dry", 0.015, 0.025), ("wet", -0.03, -0.003)])
def test_skin_keeps_its_clearance_in_contact(coupling, low, high, small_scene):
    scene = small_scene("pressed", f"contact.coupling={coupling}")
    sensor = Sensor.for_scene(scene)
    state = timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest)
    view = sensor.view(state, deformation)
    distance = view.indenter.distance(facet_points(view.body, sensor.elastomer.body.faces))[0]
    assert low < distance.min() < high


def test_cells_stay_disjoint_from_skin_and_object(small_scene):
    scene = small_scene("pressed")
    sensor = Sensor.for_scene(scene)
    state = timeline(scene)[0]
    view = sensor.view(state, sensor.deform(state, sensor.rest))
    assert view.indenter.distance(view.infill)[0].min() > 0.3


@pytest.mark.parametrize("design", ["mini-magictac", "gelsight-type", "see-through-markers"])
def test_contact_mask_covers_the_contact_and_nothing_else(design, small_scene):
    from magicsim.camera.projection import pixel_landing_mm
    from magicsim.simulation.truth import contact_mask

    scene = small_scene("pressed", f"design={design}")
    sensor = Sensor.for_scene(scene)
    deformation = sensor.deform(timeline(scene)[0], sensor.rest)
    mask = contact_mask(deformation, pixel_landing_mm(scene.design, scene.rig.lens, scene.rig.camera))
    rows, columns = np.nonzero(mask)
    assert rows.mean() == pytest.approx(31.5, abs=1)
    assert columns.mean() == pytest.approx(23.5, abs=1)
    pixel_mm2 = (scene.rig.camera.field_mm / 48) ** 2
    assert mask.sum() * pixel_mm2 == pytest.approx(deformation.contact_area_mm2, rel=0.25)
    assert not contact_mask(sensor.rest, pixel_landing_mm(scene.design, scene.rig.lens, scene.rig.camera)).any()
