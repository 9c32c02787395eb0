"""Tests that draw: which libraries can, here."""

import pytest


def can_draw() -> bool:
    """Whether this VTK draws without a display."""
    from vtkmodules.vtkCommonCore import vtkVersion

    return (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 4)


def skip_where_nothing_draws() -> None:
    """End a test that draws, where pyvista is missing or its VTK needs a display."""
    pytest.importorskip("pyvista")
    if not can_draw():
        pytest.skip("this VTK needs a display, as the error says")
