"""Logs of other programs in, tables of runs out: MATLAB, BAM, LeRobot, MCAP."""
