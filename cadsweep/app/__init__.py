"""A local page to see a part, pick, wish, mesh, look and take away: ``cadsweep open``, ``cs.open``.

Place in the flow: composition, as ``cli``: a thin face over the same public functions. What is done on the page can be
taken away as a command or a script that makes the same mesh, bit for bit.

=========== ========================================================================================
module      what it does
=========== ========================================================================================
`entities`  the part as plain data: solids, faces, edges with keys, and what a word for each of them is
`wishes`    what is asked of picked things and of the whole, as values; the options of ``sweep_mesh`` from them
`session`   the wishes with their history; a session file
`taking`    the command line and the script that make the mesh
`picking`   from a ray to what it meets; all tangent ones, all of a kind
`work`      what child processes do: read the part, select, estimate, mesh, write
`refusing`  the faces and cells of a refusal, and what was seen to help
`jobs`      those processes: one that keeps the part, one that meshes and can be ended at once
`skins`     what is seen of a mesh: clipped, peeled, drawn apart, a range of quality
`scene`     what the browser draws, as VTK's objects
`guard`     the token, the host, the origin: who may ask the server for anything
`server`    the server: its address, files handed over, its end
`control`   what the page's buttons do
`page/`     the page itself: HTML, CSS, a little JavaScript
=========== ========================================================================================

The server process never touches OpenCASCADE: a damaged file ends a child, and the page says so. Geometry is drawn by
the browser (vtk.js), so the server draws nothing; of a mesh only what is seen is sent.

Not handled: more than one user. Whoever has the address with its token sees, and does, the same.
"""
