"""The same mesh on another part: equal connectivity, names and numbering, nodes that move smoothly with the part.

Place in the flow: ``sweep_mesh(part, like=mesh)`` comes here instead of looking for a sweep of its own. What the mesh
is made of decides how it is carried: one sweep (:mod:`.sweep_like`), cells or columns (:mod:`.cells_like`), or solids
side by side, each as it is made.

Not handled: parts whose faces do not pair.
"""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from typing import Any

from ..brep import Part
from ..errors import CadError, InputError
from ..mesh import HexMesh
from ..options import SweepOptions
from .cells_like import cells_like, meshed_solids
from .cells_template import CellsTemplate
from .groups import make_group, put_together
from .refinement import refined
from .routes import open_part
from .run import Run
from .subsets import subset, touching_groups
from .sweep_like import sweep_like
from .template import AnyTemplate, GroupsTemplate, make_template
from .template_files import load_template

OWN = (
    *(
        "size",
        "tolerance",
        "layers",
        "bias",
        "fractions",
        "sizes",
        "counts",
        "rail_layers",
        "biases",
        "wall_layers",
        "periodic",
        "local_sizes",
    ),
    *("cuts", "decompose", "decompose_time", "fitted", "only", "skip", "interfaces"),
)
"""Options that a mesh brings along, so that none may be asked for besides."""


def as_template(like: Any) -> AnyTemplate:
    """A mesh, a file of factors or a template as a template.

    Raises
    ------
    InputError
        It is none of these, or a mesh that does not know its CAD model.
    """
    if isinstance(like, AnyTemplate):
        return like
    if isinstance(like, HexMesh):
        return make_template(like, "a mesh to be like")
    if isinstance(like, str | PathLike):
        return load_template(like)
    raise InputError(f"like must be a mesh or a .sweep.npz file, not {type(like).__name__}")


def mesh_like(source: Any, template: AnyTemplate, options: SweepOptions, run: Run) -> HexMesh:
    """Mesh a part as another one is meshed.

    Raises
    ------
    CadError
        The parts do not correspond; names the first face or edge without a partner.
    InvertedHexError
        The mesh carried here is not valid, and smoothing does not mend it.
    InputError
        Options that the mesh brings along are asked for.
    """
    for name in OWN:
        if getattr(options, name) not in (None, SweepOptions.__dataclass_fields__[name].default):
            raise InputError(f"like brings its own {name}; leave that out")
    part = open_part(source, options, run)
    return refined(_part_like(part, template, replace(options, params=None, part=None), run), options, run)


def _part_like(part: Part, template: AnyTemplate, options: SweepOptions, run: Run) -> HexMesh:
    if isinstance(template, GroupsTemplate):
        return _groups_like(part, template, options, run)
    if isinstance(template, CellsTemplate):
        return cells_like(part, template, options, run)
    return sweep_like(part, template, options, run)


def _groups_like(part: Part, template: GroupsTemplate, options: SweepOptions, run: Run) -> HexMesh:
    """Solids that do not all touch: each group of them as its partner, which has the same names."""
    part = meshed_solids(part, template.solids)
    owners = {model.name: [c for c, own in enumerate(part.owners) if own == j] for j, model in enumerate(part.models)}
    known = {name for names, _ in template.groups for name in names}
    for here, there, whose in ((known, owners, "this part"), (owners, known, "the mesh's part")):
        for name in sorted(here):
            if name not in there:
                raise CadError(f"the parts do not correspond: there is no solid '{name}' in {whose}")
    present = {frozenset(part.models[part.owners[c]].name for c in cells) for cells in touching_groups(part)}
    groups = []
    for names, own in template.groups:
        if frozenset(names) not in present:
            raise CadError(
                f"the parts do not correspond: '{names[0]}' touches other solids here than in the mesh's part"
            )
        alone = subset(part, sorted(cell for name in names for cell in owners[name]))
        groups.append(make_group(alone, _part_like(alone, own, options, run)))
    return put_together(part, groups, replace(options, **template.solids), run)
