"""What columns of a user's tables are: their names, flags and replies in, columns of the campaign format out."""
