"""``cadsweep info`` on a model of several solids says what touches what."""

import pytest

cq = pytest.importorskip("cadquery")
pytestmark = pytest.mark.cad


def test_info_lists_contacts_with_their_areas(tmp_path, capsys):
    from cadsweep.cli.show import print_info
    from cadsweep.cli.work import describe_part

    low, high = cq.Workplane().box(2, 2, 1), cq.Workplane().box(1, 1, 1).translate((0, 0, 1))
    edge = cq.Workplane().box(1, 2, 1).translate((1.5, 0, 1))
    whole = cq.Assembly(name="all").add(low, name="low").add(high, name="high").add(edge, name="edge")
    whole.export(str(tmp_path / "all.step"))
    data = describe_part(str(tmp_path / "all.step"), params=None, on_progress=lambda stage, share: None)
    found = {tuple(contact["solids"]): (contact["kind"], contact["area"]) for contact in data["contacts"]}
    assert found == {("low", "high"): ("face", pytest.approx(1)), ("low", "edge"): ("edge", 0)}
    for contact in data["contacts"]:
        first, second = ([s["name"] for s in data["solids"]].index(name) for name in contact["solids"])
        for one, other in contact["faces"]:
            areas = [
                next(f["area"] for f in data["faces"] if (f["solid"], f["id"]) == place)
                for place in ((first, one), (second, other))
            ]
            assert areas[0] == pytest.approx(areas[1])
    print_info(data)
    text = capsys.readouterr().out
    assert "What touches what" in text
    assert "low and edge" in text
    assert "an edge alone" in text
