"""Campaign about any FMU in, its identified parameters and the FMU with these start values out."""
