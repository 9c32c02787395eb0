"""Separate solids made one part: what they touch in becomes faces, edges and vertices that they share.

============= =============================================================================================
module        what it does
============= =============================================================================================
`joining`     :func:`~.joining.imprint`: from solids to a :class:`~cadsweep.brep.Part`, checked
`fusing`      OpenCASCADE's general fuse of those solids that may touch, and what became of each face and edge
`whole_faces` convex solids that touch in whole faces, which share these without it
`seams`       seams of coaxial round faces brought to one angle before that
`overlaps`    the larger of two solids that overlap cut, where that is asked for
`internals`   what a face holds inside where a solid only rests on it
`gaps`        solids that nearly touch
`steps`       short edges that imprinting leaves
`doubts`      what is said of both
`contacts`    :func:`~.contacts.find_contacts`: which solids touch, and in what
`checking`    what is refused: overlaps, duplicates, lost faces, changed volumes
============= =============================================================================================
"""
