"""Sets of real measurements in, campaigns, results of the usual commands, figures, pictures and a page out."""
