"""Nothing in, `THRESHOLDS` out: every number that decides an outcome of the search, grouped by room."""
