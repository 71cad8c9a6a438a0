"""The page, the style and the numbers that all reports share."""
