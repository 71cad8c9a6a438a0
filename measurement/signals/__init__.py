"""`Run` in, facts about its signals out: noise, encoder step, cycles, harmonics, control, smoothed motion."""
