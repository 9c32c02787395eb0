"""Files, scripts and objects read as a :class:`~cadsweep.cad.read.model.Model`, names and colours with them."""
