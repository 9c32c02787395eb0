"""Tests that draw: what can, here."""

import pytest


def can_draw(*, display: bool = True) -> bool:
    """Whether VTK draws here, on a display or without one; without, where there is none to be used."""
    from vtkmodules.vtkCommonCore import vtkVersion

    from cadsweep.view.display import can_open_window

    draws_without = (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 4)
    return draws_without or (display and can_open_window())


def skip_where_nothing_draws() -> None:
    """End a test that draws, where pyvista is missing or its VTK needs a display."""
    pytest.importorskip("pyvista")
    if not can_draw():
        pytest.skip("this VTK needs a display, as the error says")
