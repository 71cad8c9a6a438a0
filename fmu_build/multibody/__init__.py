"""Identified devices for multibody simulators: device and values in, URDF and MJCF out."""
