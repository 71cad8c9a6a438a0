"""A parameter set of joint 4 that tests of readers share: two parameters and a state."""

from haptid.fmu_build.exchange.ssv import ssv_bytes
from haptid.model.equations.fmu_names import POSITION, of_joint

STATE = of_joint(4, POSITION)
VALUES = {"joint4.spring.Ks": 0.02, "joint4.friction.vs": 0.1, STATE: 0.3}
UNITS = {"joint4.spring.Ks": "N m/rad", "joint4.friction.vs": "rad/s", STATE: "rad"}
GOOD = ssv_bytes(VALUES, UNITS).decode()
