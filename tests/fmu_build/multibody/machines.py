"""Devices that the tests of multibody files share."""

from __future__ import annotations

import tomllib
from functools import cache

from haptid.fmu_build.multibody.bodies import Multibody, multibody
from haptid.model.device.device import Device
from haptid.model.device.device_table import parse_device
from haptid.model.device.reader import load_device
from haptid.model.joint.whole_device import full_equations
from haptid.support.files.place import Place

ODD = """
name = "odd"
title = "a sliding joint, a joint that turns its link backwards, a link that two joints turn"
gravity = [0.0, 0.5, -9.7]
[[joints]]
name = "first"
[[joints]]
name = "backwards"
[[joints]]
name = "slide"
prismatic = true
position_limits = [-0.1, 0.2]
torque_limit = 3.0
[[links]]
name = "a"
axis = [0, 0, 1]
rpy = [0.3, -0.2, 0.5]
moved_by = { 0 = 1 }
mass = 0.3
centroid = [0.02, 0.01, 0.05]
inertia = { I11 = 4e-4, I22 = 5e-4, I33 = 3e-4, I12 = 2e-5 }
[[links]]
name = "b"
parent = "a"
origin = [0.1, 0.0, 0.2]
axis = [0.6, 0, 0.8]
moved_by = { 1 = -1 }
mass = 0.2
centroid = [0.0, 0.03, 0.01]
inertia = { I11 = 2e-4, I22 = 2e-4, I33 = 1e-4 }
[[links]]
name = "c"
parent = "a"
origin = [0.0, 0.1, 0.0]
axis = [0, 1, 0]
moved_by = { 0 = 1, 1 = 2 }
mass = 0.1
centroid = [0.05, 0.0, 0.02]
inertia = { I11 = 1e-4, I22 = 2e-4, I33 = 2e-4 }
[[links]]
name = "d"
parent = "b"
origin = [0.0, 0.0, 0.1]
axis = [0, 0, 1]
motion = "prismatic"
moved_by = { 2 = 1 }
mass = 0.15
centroid = [0.0, 0.01, 0.0]
inertia = { I11 = 1e-4, I22 = 1e-4, I33 = 1e-4 }
"""
NAMES = ("freedom6s", "double_pendulum", "arm6", "odd")


@cache
def device(name: str) -> Device:
    return parse_device(tomllib.loads(ODD), Place(file="odd.toml")) if name == "odd" else load_device(name)


@cache
def values_of(name: str) -> dict[str, float]:
    """First guesses, with springs that are slack elsewhere than at 0, and a gain."""
    guesses = {q.id: float(q.initial) for q in full_equations(device(name)).parameters}
    slack = {id: 0.02 * (1 + int(id[-1])) for id in guesses if id.startswith("epos_")}
    return guesses | slack | {"Kp_1": 1.1}


@cache
def machine(name: str) -> Multibody:
    return multibody(device(name), values_of(name), name)
