"""Results of fits, posteriors and searches in, what an FMU says of its accuracy out: verification and draws."""
