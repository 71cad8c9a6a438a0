"""Device TOML or URDF in, `Device` out, checked; built-in devices."""
