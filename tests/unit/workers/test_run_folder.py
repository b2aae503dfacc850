from magicsim.workers.run_folder import changed_versions, versions


def test_versions_that_differ_or_that_only_one_side_knows_are_named():
    before, now = {"numpy": "2.2", "scipy": "1.17", "gone": "1"}, {"numpy": "2.3", "scipy": "1.17", "new": "1"}
    assert changed_versions(before, now) == ["gone", "new", "numpy"]
    assert changed_versions(versions(), versions()) == []


def test_versions_name_the_renderer_and_the_program():
    assert {"magicsim", "mitsuba", "numpy"} <= versions().keys()
