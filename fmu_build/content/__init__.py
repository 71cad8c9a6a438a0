"""Interface in, what stands in an FMU beside its code out: documentation, licences, picture, reference run."""
