"""Two revisions of the code on the same campaigns: commands of each in, measured differences of their results out."""
