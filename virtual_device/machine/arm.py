"""The six-joint arm: the Python side of ``arm.c``."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping

import numpy as np

from haptid.support.errors import NumericalError
from haptid.virtual_device.machine.compiled import Array, Doubles, doubles, library
from haptid.virtual_device.machine.truth import DRIVE, Truth

JOINTS = 6
HIDDEN = ("cubic", "cog", "cog_number", "cog_phase", "drag_up", "drag_down", "drag_square", "gain_fall")
"""What may be hidden in a joint, as `arm.c` names it."""
ELEMENTS = 6
"""Most states that friction of one joint has, as `friction.h` has it."""
STATES = 2 * JOINTS + 2 * JOINTS * ELEMENTS
"""Length of a state: positions, velocities, `ELEMENTS` friction states a joint, and where each element slips."""
MAX_STEP = 1e-4
"""Longest Runge–Kutta step [s]."""


@functools.cache
def _functions() -> ctypes.CDLL:
    lib = library("arm")
    integer, flags = ctypes.c_int, ctypes.POINTER(ctypes.c_int)
    lib.arm_dynamics.argtypes = [Doubles] * 5
    lib.arm_dynamics.restype = None
    lib.arm_potential.argtypes = [Doubles] * 3
    lib.arm_potential.restype = ctypes.c_double
    lib.arm_advance.argtypes = [Doubles, Doubles, flags, Doubles, Doubles, ctypes.c_double, integer, Doubles]
    return lib


class Arm:
    """A machine with six joints; all arrays are indexed by joint number 0..5.

    Parameters
    ----------
    truth
        Numbers of the machine.
    hidden
        Disturbances of each joint by the names of `HIDDEN`: torques against the motion cubic·(q − epos)³,
        cog·sin(cog_number·q + cog_phase), drag_up·q̇ or drag_down·q̇ by direction, drag_square·|q̇|·q̇, and a command
        that arrives as τ·(1 − gain_fall·τ²). SI units; none where None.

    Raises
    ------
    ValueError
        Where something else is to be hidden: it would not be, and a study of it would find nothing.
    InputError
        Where the friction law of a joint is unknown.
    NumericalError
        Where ``arm.c`` does not compile, or has other parameters and states than this side.
    """

    def __init__(self, truth: Truth, hidden: Mapping[int, Mapping[str, float]] | None = None) -> None:
        self.truth, self._packed = truth, truth.packed()
        given = [(hidden or {}).get(j, {}) for j in range(JOINTS)]
        if unknown := {name for one in given for name in one if name not in HIDDEN}:
            msg = f"an arm hides {', '.join(HIDDEN)}, got {', '.join(sorted(unknown))}"
            raise ValueError(msg)
        self._hidden = np.array([[float(one.get(name, 0.0)) for name in HIDDEN] for one in given])
        sizes = _functions().arm_parameter_count(), _functions().arm_state_count()
        if sizes != (self._packed.size, STATES):
            msg = f"the arm has {sizes[0]} parameters and {sizes[1]} states, got {self._packed.size} and {STATES}"
            raise NumericalError(msg)

    def dynamics(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return mass matrix M and torque h of M a + h = τ, without springs and friction.

        Parameters
        ----------
        q
            Positions [rad], shape (6,).
        v
            Velocities [rad/s], shape (6,).

        Returns
        -------
        M : Array
            Mass matrix [kg m²], shape (6, 6).
        h : Array
            Gravity, centrifugal and Coriolis torque [N m], shape (6,).
        """
        M, h = np.empty((JOINTS, JOINTS)), np.empty(JOINTS)
        q, v = np.array(q, dtype=float), np.array(v, dtype=float)
        _functions().arm_dynamics(doubles(self._packed), doubles(q), doubles(v), doubles(M), doubles(h))
        return M, h

    def potential(self, q: Array) -> float:
        """Return the gravitational energy.

        Parameters
        ----------
        q
            Positions [rad], shape (6,).

        Returns
        -------
        float
            Energy [J].
        """
        q, handle = np.array(q, dtype=float), np.empty(3)
        return float(_functions().arm_potential(doubles(self._packed), doubles(q), doubles(handle)))

    def handle(self, q: Array) -> Array:
        """Return the position of the handle's control point in the base frame.

        Parameters
        ----------
        q
            Positions [rad], shape (6,).

        Returns
        -------
        Array
            Position [m], shape (3,).
        """
        q, handle = np.array(q, dtype=float), np.empty(3)
        _functions().arm_potential(doubles(self._packed), doubles(q), doubles(handle))
        return handle

    def static_torque(self, q: Array) -> Array:
        """Return the torque of gravity and springs at rest.

        Parameters
        ----------
        q
            Positions [rad], shape (6,).

        Returns
        -------
        Array
            Torque that holds the arm there [N m], shape (6,).
        """
        drive = dict(zip(DRIVE, self.truth.drives.T, strict=True))
        spring: Array = drive["Ks"] * (q - drive["epos"])
        return self.dynamics(q, np.zeros(JOINTS))[1] + spring

    def stiffness(self, q: Array, step: float = 1e-4) -> Array:
        """Return the derivative of `static_torque` by central differences.

        Parameters
        ----------
        q
            Positions [rad], shape (6,).
        step
            Half the distance of the differences [rad].

        Returns
        -------
        Array
            ∂τ_i/∂q_j [N m/rad], shape (6, 6).
        """
        shifts = step * np.eye(JOINTS)
        return np.array([(self.static_torque(q + d) - self.static_torque(q - d)) / (2 * step) for d in shifts]).T

    def rest(self, free: tuple[int, ...], posture: Array) -> Array:
        """Return the position at which the free joints balance without torque, by Newton's method.

        Parameters
        ----------
        free
            Numbers of the free joints.
        posture
            Positions of the locked joints, and where the search for the free ones begins [rad], shape (6,).

        Returns
        -------
        Array
            Positions [rad], shape (6,).

        Raises
        ------
        NumericalError
            Where the balance is not found in 30 steps.
        """
        index, q = list(free), np.array(posture, dtype=float)
        for _ in range(30):
            excess = self.static_torque(q)[index]
            if np.max(np.abs(excess)) < 1e-14:
                return q
            q[index] -= np.linalg.solve(self.stiffness(q)[np.ix_(index, index)], excess)
        msg = f"joints {free} have no rest near {posture}: {excess} N m remain"
        raise NumericalError(msg)

    def locked_joint(self, joint: int, posture: Array) -> dict[str, float]:
        """Return the parameters of one free joint with the others locked, as `joint` takes them.

        With one revolute joint free, M_ii does not change and gravity is g_c cos q + g_s sin q.

        Parameters
        ----------
        joint
            Number of the free joint.
        posture
            Positions of the others [rad], shape (6,).

        Returns
        -------
        dict of str to float
            Value by name, SI units: inertia, gravity, `DRIVE` and, where the truth names a friction law, the law's own.
        """
        q, still = np.array(posture, dtype=float), np.zeros(JOINTS)
        torque = []
        for angle in (0.0, np.pi / 2):
            q[joint] = angle
            M, h = self.dynamics(q, still)
            torque.append(float(h[joint]))
        base = {"inertia": float(M[joint, joint]), "gravity_cos": torque[0], "gravity_sin": torque[1]}
        own = self.truth.law_parameters(joint) if joint in self.truth.friction else {}
        return base | dict(zip(DRIVE, map(float, self.truth.drives[joint]), strict=True)) | own

    def start(self, q: Array, v: Array | None = None) -> Array:
        """Return a state with relaxed friction.

        Parameters
        ----------
        q
            Positions [rad], shape (6,).
        v
            Velocities [rad/s], shape (6,); 0 where None.

        Returns
        -------
        Array
            State, shape (`STATES`,).
        """
        state = np.zeros(STATES)
        state[:JOINTS] = q
        if v is not None:
            state[JOINTS : 2 * JOINTS] = v
        return state

    def advance(
        self,
        free: tuple[int, ...],
        state: Array,
        torque: Array,
        duration: float,
        end: Array | None = None,
        *,
        max_step: float = MAX_STEP,
    ) -> None:
        """Move a state on in place, the torque running linearly from one value to another.

        Parameters
        ----------
        free
            Numbers of the joints that move; the others are locked.
        state
            State as `start` makes it, shape (`STATES`,); it holds the result.
        torque
            Torque at the beginning [N m], shape (6,).
        duration
            Length of the motion [s].
        end
            Torque at the end [N m], shape (6,); that of the beginning where None.
        max_step
            Longest Runge–Kutta step [s].

        Raises
        ------
        ValueError
            Where the state has another length.
        NumericalError
            Where the motion stops being finite.
        """
        if state.shape != (STATES,):
            msg = f"a state of the arm has shape {(STATES,)}, got {state.shape}"
            raise ValueError(msg)
        flags = (ctypes.c_int * JOINTS)(*[int(j in free) for j in range(JOINTS)])
        steps = max(1, int(np.ceil(duration / max_step - 1e-9)))
        u0 = np.ascontiguousarray(torque, dtype=float)
        u1 = u0 if end is None else np.ascontiguousarray(end, dtype=float)
        machine = doubles(self._packed), doubles(self._hidden)
        if _functions().arm_advance(*machine, flags, doubles(u0), doubles(u1), duration, steps, doubles(state)):
            msg = "the arm's motion stopped being finite"
            raise NumericalError(msg)
