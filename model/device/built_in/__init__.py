"""Devices that come with the package, as TOML and URDF files."""
