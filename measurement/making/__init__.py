"""Tables of any shape in, campaign folder out."""
