"""Joint in, `Finding` out: search, verdict, rebuilt FMU, gap before and after."""
