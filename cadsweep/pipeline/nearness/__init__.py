"""As near to the CAD as is asked for: `nearer` is the one loop, the others measure and divide what it meshes.

=============== =======================================================================
module          what it does
=============== =======================================================================
nearer          what is allowed, and the loop
measured        how far a mesh of cells is off the CAD faces
cells_accuracy  sweeps and cells; `stack_accuracy` columns
cap_sizes       quads of curved caps; `cell_cap_sizes` carries that from cell to cell
uneven          edges of caps divided unevenly, where nobody else has them
curvature       edges divided by how they bend
crossing_facets edges divided where facets cross
=============== =======================================================================
"""
