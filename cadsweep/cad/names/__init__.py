"""What users call faces, edges and solids: made valid, carried along, and looked up."""
