"""Work of many starts and walkers in, their results out: processes of this machine, or of a cluster."""
