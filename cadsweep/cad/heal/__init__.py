"""A model made clean: sewn, oriented, sized, closed faces divided, slivers gone; what was done is known."""
