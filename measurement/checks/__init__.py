"""`Campaign` in, one that is ready for fits out, or refused: clocks, sizes, motion, what it states; its summary."""
