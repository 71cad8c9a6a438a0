"""From equations to compiled code: C source, compilation, calls."""
