"""Pictures: the grid is the mesh, a clip keeps whole hexahedra, and a PNG needs no display."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cadsweep.errors import CadSweepError, InputError
from cadsweep.quality import scaled_jacobians
from cadsweep.view import boundary_colors, kept_by_clip, mesh_colors, outline, plot, skin
from cadsweep.view.clipping import cut_skin, left_of_rim
from cadsweep.view.exploded import explode
from cadsweep.view.grid import legible

from ..pictures import can_draw
from .view_blocks import of_order_2, painted_block, twisted_block, unit_cube

pytest.importorskip("pyvista")
_WHY = "this VTK needs a display, as the error says"
draws = pytest.mark.skipif(not can_draw(), reason=_WHY)
draws_without_display = pytest.mark.skipif(not can_draw(display=False), reason=_WHY)


def pixels(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB"), dtype=int)


def colored(image):
    """Pixels that are neither white nor grey."""
    return np.ptp(image, axis=-1) > 40


class TestGrid:
    def test_it_is_the_mesh(self):
        mesh = twisted_block()
        grid = mesh.to_pyvista()
        np.testing.assert_array_equal(grid.points, mesh.points)
        np.testing.assert_array_equal(grid.cells_dict[12], mesh.hexes)
        np.testing.assert_array_equal(grid.cell_data["scaled_jacobian"], scaled_jacobians(mesh.points, mesh.hexes))
        assert list(grid.field_data["boundary_names"]) == list(mesh.boundaries)

    def test_its_quality_is_what_vtk_says(self):
        grid = twisted_block().to_pyvista()
        theirs = grid.cell_quality("scaled_jacobian").cell_data["scaled_jacobian"]
        np.testing.assert_allclose(grid.cell_data["scaled_jacobian"], theirs, atol=1e-12)

    @pytest.mark.parametrize(("n_nodes", "vtk_type"), [(20, 25), (27, 29)])
    def test_order_2_has_its_own_cells(self, n_nodes, vtk_type):
        # Every node of a hexahedron lies where VTK's own table of the cell's nodes says, within the unit cube.
        cube = of_order_2(unit_cube(), n_nodes).to_pyvista()
        cell = cube.GetCell(0)
        table = [cell.GetParametricCoords()[i] for i in range(3 * n_nodes)]
        np.testing.assert_allclose(cube.points[cube.cells[1:]], np.reshape(table, (-1, 3)), atol=1e-15)
        mesh = twisted_block()
        assert set(of_order_2(mesh, n_nodes).to_pyvista().celltypes) == {vtk_type}
        surface, owners = skin(of_order_2(mesh, n_nodes))
        assert (owners >= 0).all()
        assert surface.n_cells == sum(map(len, mesh.boundaries.values()))

    def test_its_skin_is_the_boundaries(self):
        mesh = twisted_block()
        surface, owners = skin(mesh)
        for i, quads in enumerate(mesh.boundaries.values()):
            assert (owners == i).sum() == len(quads)
        assert surface.n_cells == sum(map(len, mesh.boundaries.values()))

    def test_a_clip_lays_the_inside_open(self):
        mesh = twisted_block(turn=0.0)
        kept = kept_by_clip(mesh, "x")
        assert kept.sum() == mesh.n_hexes // 2
        _, owners = skin(mesh, kept)
        assert (owners == -1).sum() == 4 * 6  # the cut runs between hexahedra: 4 across, 6 layers
        np.testing.assert_array_equal(kept_by_clip(mesh, "-x"), ~kept)

    @pytest.mark.parametrize(
        "clip", ["w", "xy", 3, ((0, 0, 0), (0, 0, 0)), ((1, 0), (0, 0)), ((np.nan, 0, 1), (0, 0, 0))]
    )
    def test_a_clip_that_is_no_plane_is_refused(self, clip):
        with pytest.raises(InputError, match="clip"):
            kept_by_clip(twisted_block(), clip)

    def test_the_outline_of_a_patch_is_its_rim(self):
        mesh = twisted_block(n=4, n_layers=6)
        assert len(outline(mesh.boundaries["source"])) == 16
        assert len(outline(mesh.boundaries["side_1"])) == 2 * (4 + 6)

    def test_legends_can_be_read_on_white(self):
        assert legible("#ffffff") == "#a6a6a6"  # 0.65 of 255 is 166
        assert legible("#0000ff") == "#0000ff"

    def test_of_overlapping_boundaries_the_smallest_is_seen(self):
        mesh = painted_block()
        _, owners = skin(mesh)
        assert {list(mesh.boundaries)[i] for i in np.unique(owners)} == set(mesh.boundaries) - {"caps"}

    def test_colours_of_boundaries_differ(self):
        assert len(set(boundary_colors(24))) == 24

    def test_boundaries_have_the_colours_of_the_cad_and_the_others_are_unlike_those(self):
        mesh = painted_block()
        colors = dict(zip(mesh.boundaries, mesh_colors(mesh), strict=True))
        assert (colors["source"], colors["target"]) == ("#ff0000", "#00ff00")
        assert len(set(colors.values())) == len(colors)
        for name in set(colors) - {"source", "target"}:
            red, green, blue = (int(colors[name][i : i + 2], 16) for i in (1, 3, 5))
            assert abs(255 - red) + green + blue > 90
            assert red + abs(255 - green) + blue > 90
        assert mesh_colors(twisted_block()) == boundary_colors(6)


class TestPicture:
    @draws_without_display
    @pytest.mark.parametrize(
        "options", [{}, {"scalars": "boundary"}, {"clip": "x"}, {"scalars": None, "clip": ((1, 1, 0), (0, 0, 1))}]
    )
    def test_a_png_is_drawn_without_a_display(self, tmp_path, monkeypatch, options):
        monkeypatch.delenv("DISPLAY", raising=False)
        picture = tmp_path / "block.png"
        assert twisted_block().plot(screenshot=picture, window_size=(300, 240), **options) == picture
        image = pixels(picture)
        assert image.shape == (240, 300, 3)
        assert (image.min(axis=-1) < 250).mean() > 0.08
        assert sorted(p.name for p in tmp_path.iterdir()) == ["block.png"]

    @draws
    @pytest.mark.parametrize(("scalars", "seen"), [("cad", [True, True]), ("boundary", [True, False])])
    def test_the_colours_of_the_cad_are_drawn(self, tmp_path, scalars, seen):
        camera = [(6, -8, -10), (0, 0, 2), (0, 0, 1)]  # the source and two sides are in sight
        plot(
            painted_block(), screenshot=tmp_path / "a.png", scalars=scalars, show_boundaries=False,
            window_size=(300, 300), camera=camera,
        )  # fmt: skip
        image = pixels(tmp_path / "a.png")
        others = [image[..., [1, 2]].max(axis=-1), image[..., [0, 1]].max(axis=-1)]
        found = [((image[..., c] > 60) & (other < 10)).mean() > 0.02 for c, other in zip((0, 2), others, strict=True)]
        assert found == seen

    @draws
    def test_an_inverted_hexahedron_is_red(self, tmp_path):
        mesh = twisted_block()
        mesh.points[mesh.hexes[-1, 6]] = mesh.points[mesh.hexes[-1, 0]] - 0.2
        plot(mesh, screenshot=tmp_path / "a.png", show_boundaries=False, window_size=(400, 400))
        red = np.array([[[1, 0, 0]]])
        image = pixels(tmp_path / "a.png")
        assert ((image * red == image).all(axis=-1) & (image[..., 0] > 90)).sum() > 20

    @draws
    def test_a_picture_that_cannot_be_written_is_an_error(self, tmp_path):
        with pytest.raises(CadSweepError, match="no_such_folder"):
            plot(twisted_block(), screenshot=tmp_path / "no_such_folder" / "a.png", window_size=(60, 60))

    @draws
    def test_options_are_checked(self, tmp_path):
        with pytest.raises(InputError, match=r"\.png"):
            plot(twisted_block(), screenshot=tmp_path / "a.bmp")
        with pytest.raises(InputError, match="'boundary'"):
            plot(twisted_block(), screenshot=tmp_path / "a.png", scalars="temperature")
        with pytest.raises(InputError, match="takes every hexahedron away"):
            plot(twisted_block(), screenshot=tmp_path / "a.png", clip=((0, 0, 1), (0, 0, -9)))
        assert not list(tmp_path.iterdir())

    @draws_without_display
    def test_in_a_notebook_the_picture_is_the_answer(self, monkeypatch):
        monkeypatch.delenv("DISPLAY", raising=False)
        kernel = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object()))
        monkeypatch.setitem(sys.modules, "IPython", kernel)
        monkeypatch.setattr("cadsweep.view.picture.has_trame", lambda: False)  # a view to turn needs a server
        picture = plot(twisted_block(), window_size=(200, 160))
        assert picture.size == (200, 160)
        assert picture._repr_png_().startswith(b"\x89PNG")

    def test_without_a_display_a_window_is_refused(self, monkeypatch):
        if sys.platform != "linux":
            pytest.skip("other systems always have a display")
        monkeypatch.delenv("DISPLAY", raising=False)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        with pytest.raises(CadSweepError, match="screenshot"):
            plot(twisted_block())


class TestAnExplodedView:
    def two_parts(self):
        """Two layers of hexahedra, a part each, with the interface between them."""
        block = twisted_block(n_layers=2, turn=0.0)
        half = block.n_hexes // 2
        between = block.hexes[:half, 4:8]
        parts = {"low": np.arange(half), "high": np.arange(half, 2 * half)}
        return replace(block, parts=parts, interfaces={"low__high": between}, structure=None)

    def test_parts_move_away_from_the_middle_and_keep_their_shape(self):
        mesh = self.two_parts()
        apart = explode(mesh, 0.5)
        # Middles at 1 and 3 of 4: a half of 1 down, and up.
        for name, move in (("low", -0.5), ("high", 0.5)):
            before, after = mesh.points[mesh.hexes[mesh.parts[name]]], apart.points[apart.hexes[apart.parts[name]]]
            assert np.allclose(after - before, [0, 0, move])
        assert not np.intersect1d(*(np.unique(apart.hexes[ids]) for ids in apart.parts.values())).size

    def test_contacts_are_laid_open_on_both_sides(self):
        mesh = self.two_parts()
        apart = explode(mesh, 1.0)
        assert len(apart.boundaries["low__high"]) == 2 * len(mesh.interfaces["low__high"])
        assert sum(map(len, apart.boundaries.values())) == sum(map(len, mesh.boundaries.values())) + 32

    def test_a_part_within_another_is_drawn_beside_it(self):
        block = twisted_block(n=6, n_layers=2, turn=0.0)
        x, y, _ = block.points[block.hexes].mean(axis=1).T
        inner = np.flatnonzero((abs(x) < 0.4) & (abs(y) < 0.4))
        outer = np.setdiff1d(np.arange(block.n_hexes), inner)
        apart = explode(replace(block, parts={"pin": inner, "plate": outer}, structure=None), 1.0)
        boxes = [apart.points[apart.hexes[ids]].reshape(-1, 3) for ids in apart.parts.values()]
        assert any(boxes[0].max(axis=0)[k] < boxes[1].min(axis=0)[k] for k in range(3))

    def test_a_factor_that_is_none_is_refused_and_one_part_stays(self):
        with pytest.raises(InputError, match="explode"):
            explode(self.two_parts(), -1.0)
        block = twisted_block()
        assert explode(block, 1.0) is block

    @draws
    def test_it_is_drawn_with_the_names_of_the_parts(self, tmp_path):
        path = self.two_parts().plot(screenshot=tmp_path / "apart.png", scalars="part", explode=1.0)
        assert path.stat().st_size > 5_000


@draws_without_display
def test_where_nothing_can_draw_the_package_to_install_is_named(monkeypatch, tmp_path):
    def missing(name):
        raise OSError(f"{name}: cannot open shared object file")

    monkeypatch.setattr("cadsweep.view.display.can_open_window", lambda: False)
    monkeypatch.setattr("ctypes.CDLL", missing)
    with pytest.raises(CadSweepError, match="libegl1"):
        plot(twisted_block(), screenshot=tmp_path / "a.png")


def test_without_pyvista_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(CadSweepError, match=r"cadsweep\[view\]"):
        twisted_block().to_pyvista()


def test_a_smooth_clip_cuts_hexahedra_and_leaves_nothing_beyond_the_plane():
    mesh = twisted_block()
    normal, origin = np.array([0.6, 0.8, 0.0]), np.zeros(3)
    whole, cut = (pytest.importorskip("pyvista").wrap(cut_skin(mesh, side)[0]) for side in ((normal, origin), ("x")))
    assert ((np.asarray(whole.points) - origin) @ normal).max() < 1e-6
    assert np.asarray(cut.points)[:, 0].max() == pytest.approx(0.0, abs=1e-6)
    # The half that is kept and the half that is taken have the mesh's volume between them, so both are closed.
    halves = [cut_skin(mesh, (sign * normal, origin))[0].triangulate() for sign in (1, -1)]
    assert sum(half.volume for half in halves) == pytest.approx(mesh.quality().volume, rel=2e-2)


@pytest.mark.parametrize("crinkle", [False, True])
def test_no_outline_is_left_of_the_half_that_is_taken_away(crinkle):
    mesh = twisted_block(turn=0.0)
    kept = kept_by_clip(mesh, "x") if crinkle else None
    for quads in mesh.boundaries.values():
        lines = left_of_rim(mesh, outline(quads[:, :4]), clip="x", kept=kept)
        if lines is not None:
            assert np.asarray(lines.points)[np.unique(lines.lines.reshape(-1, 3)[:, 1:]), 0].max() < 1e-6


def test_a_histogram_is_written_over_the_range_of_the_data(tmp_path):
    pytest.importorskip("matplotlib")
    report = twisted_block().quality()
    assert report.plot(screenshot=tmp_path / "quality.png").stat().st_size > 1000
    edges, counts = report.histogram
    assert counts[0] > 0
    assert edges[0] <= report.min_scaled_jacobian < edges[1]
    with pytest.raises(InputError, match="there is no metric 'angle'; there are scaled_jacobian"):
        report.plot(metric="angle", screenshot=tmp_path / "quality.png")
