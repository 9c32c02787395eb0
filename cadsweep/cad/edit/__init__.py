"""A loaded part changed for a sweep: cut open, divided, merged; names and ids kept."""
