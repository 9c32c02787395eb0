"""What the scripts of the gallery promise, and where its page has to say so."""

import ast


def promise(path):
    """The worst scaled Jacobian that a script states."""
    (value,) = (
        statement.value.value
        for statement in ast.parse(path.read_text()).body
        if isinstance(statement, ast.Assign)
        and isinstance(statement.targets[0], ast.Name)
        and statement.targets[0].id == "MIN_SCALED_JACOBIAN"
    )
    return value


def check_shown(path):
    """The gallery's page has the model, its promise and a picture of it."""
    docs = path.parents[2] / "docs"
    assert f"**`{path.stem}`** ({promise(path)})" in (docs / "gallery.md").read_text(encoding="utf-8")
    assert 1_000 < (docs / "images" / f"{path.stem}.png").stat().st_size < 200_000
