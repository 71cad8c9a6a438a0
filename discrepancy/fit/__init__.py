"""Study in, `Solution` out: nominal and candidate fits with their noise."""
