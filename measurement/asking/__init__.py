"""Questions on a terminal in, what the user means by the tables out."""
