"""Effects and solution in, refitted candidates out."""
