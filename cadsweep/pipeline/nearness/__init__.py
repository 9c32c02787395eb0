"""As near to the CAD as is asked for: `nearer` is the one loop, the others measure and divide what it meshes.

=============== =======================================================================
module          what it does
=============== =======================================================================
nearer          what is allowed, and the loop
accuracy        one sweep; `cells_accuracy` cells, `stack_accuracy` columns
cap_sizes       quads of curved caps; `cell_cap_sizes` those of cells
curvature       edges divided by how they bend
dividing        counts, and again where a cap cannot be meshed
crossing_facets edges divided where facets cross
=============== =======================================================================
"""
