"""`Equations` in, variables, units and model description out."""
