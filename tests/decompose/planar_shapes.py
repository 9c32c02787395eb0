"""Planar complexes drawn by hand."""

from itertools import product

from cadsweep.decomposition.planar import Pool

#: Corners of a box by number, 4 x + 2 y + z; its faces, seen from outside counter-clockwise.
BOX = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
NORMALS = ((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1))


def box_cell(pool, low, high, *, inward=False, origin=0):
    """A box as a cell, or the shell of a void in the shape of one."""
    corners = [pool.vertex(tuple((low, high)[b][k] for k, b in enumerate(bits))) for bits in product((0, 1), repeat=3)]
    cell = []
    sign = -1.0 if inward else 1.0
    for j, (loop, normal) in enumerate(zip(BOX, NORMALS, strict=True)):
        offset = sum(n * x for n, x in zip(normal, high if sum(normal) > 0 else low, strict=True))
        vertices = tuple(corners[c] for c in loop)
        loops = (vertices[::-1] if inward else vertices,)
        cell.append((pool.facet(loops, tuple(sign * n for n in normal), sign * offset, origin + j), 1))
    return tuple(cell)


def unit_box():
    """A pool with one box of 1 x 1 x 1, one corner in the origin."""
    pool = Pool(size=3**0.5)
    return pool, box_cell(pool, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))


def hollow_box():
    """A box of 3 x 3 x 3 with a void of 1 x 1 x 1 in its middle."""
    pool = Pool(size=27**0.5)
    outer = box_cell(pool, (0.0, 0.0, 0.0), (3.0, 3.0, 3.0))
    return pool, outer + box_cell(pool, (1.0, 1.0, 1.0), (2.0, 2.0, 2.0), inward=True, origin=6)
