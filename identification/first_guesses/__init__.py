"""`Equations` and the runs of one configuration in, `Equations` with first guesses and ranges from these runs out."""
