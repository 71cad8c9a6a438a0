"""First guesses of effects that resonate, from frequency responses: `Run`s and `Effect`s in, start values out."""
