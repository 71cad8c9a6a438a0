"""The `Simulator` protocol and what satisfies it: FMU, kernel, observer, inverse dynamics, closed loop."""
