"""Tools of a search and nominal model in, leading effects and friction laws out: compared near the readings."""
