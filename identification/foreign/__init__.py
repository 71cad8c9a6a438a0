"""Other people's FMUs behind a process border."""
