"""Words of notes that others look for; here, so that nobody imports OpenCASCADE for them."""

ANNULI_NOTE = "plane faces with a hole divided"
"""Begins the note of :func:`cadsweep.cad.edit.annuli.divide_annuli`."""
TIPS_NOTE = "tips bridged"
"""Begins the note of :func:`cadsweep.cad.edit.bridging.bridge_tips`."""
