"""Freedom 6S with the rod by Kane's method: the rod as a body parallel to link 2, its pin on the crank."""

import numpy as np
import sympy as sp
from sympy.physics.mechanics import KanesMethod, Point, ReferenceFrame, RigidBody, dynamicsymbols, inertia

from haptid.model.algebra.numeric_coordinates import Numbers
from haptid.model.device.reader import load_device
from haptid.model.rigid_body.composite_bodies import mass_matrix
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.newton_euler import inverse_dynamics

AXES = {
    "1": ("base", 0, "z"),
    "2": ("1", 1, "x"),
    "4": ("2", 2, "x"),
    "5": ("4", 3, "z"),
    "6": ("5", 5, "x"),
    "7": ("6", 4, "y"),
}


def kane(device):
    """Return f(q, u) → (M, forcing) of Kane's equations M·u̇ = forcing, from the lengths written out here."""
    q, u = dynamicsymbols("q:6"), dynamicsymbols("u:6")
    base, origin = ReferenceFrame("base"), Point("O")
    origin.set_vel(base, 0)
    frames, points = {"base": base}, {"1": origin, "2": origin}
    for name, (parent, j, axis) in AXES.items():
        frame = ReferenceFrame(f"F{name}")
        frame.orient_axis(frames[parent], getattr(frames[parent], axis), q[j])
        frame.set_ang_vel(frames[parent], u[j] * getattr(frames[parent], axis))
        frames[name] = frame
    crank, frames["3"] = frames["4"], frames["2"]
    elbow = origin.locatenew("E", 0.20 * frames["2"].z)
    pin = origin.locatenew("P", 0.05 * crank.y)
    wrist = elbow.locatenew("W", -0.25 * frames["4"].y)
    elbow.v2pt_theory(origin, base, frames["2"])
    pin.v2pt_theory(origin, base, crank)
    wrist.v2pt_theory(elbow, base, frames["4"])
    points |= {"3": pin, "4": elbow, "5": wrist, "6": wrist, "7": wrist}
    bodies, loads = [], []
    for link in device.massive:
        m, x, y, z, *moments = link.inertial.initial
        frame, anchor = frames[link.name], points[link.name]
        centroid = anchor.locatenew(f"C{link.name}", x * frame.x + y * frame.y + z * frame.z)
        centroid.v2pt_theory(anchor, base, frame)
        xx, yy, zz, xy, xz, yz = moments
        bodies.append(
            RigidBody(f"B{link.name}", centroid, frame, m, (inertia(frame, xx, yy, zz, xy, yz, xz), centroid))
        )
        loads.append((centroid, -9.81 * m * base.z))
    method = KanesMethod(base, q_ind=q, u_ind=u, kd_eqs=[a.diff() - b for a, b in zip(q, u, strict=True)])
    method.kanes_equations(bodies, loads)
    plain = sp.symbols("q:6 u:6")
    known = dict(zip([*q, *u], plain, strict=True))
    return sp.lambdify(
        [plain[:6], plain[6:]], [method.mass_matrix.xreplace(known), method.forcing.xreplace(known)], cse=True
    )


def test_kane_agrees_on_a_thousand_states():
    device = load_device("freedom6s")
    f, (pi, _) = kane(device), pi_prior(device)
    inertials = {link.name: tuple(pi[10 * i : 10 * i + 10]) for i, link in enumerate(device.massive)}
    rng = np.random.default_rng(5)
    q, v = rng.uniform(-2, 2, (6, 1000)), rng.uniform(-3, 3, (6, 1000))
    zero = np.zeros(1000)
    M = np.array([[zero + entry for entry in row] for row in mass_matrix(device, Numbers(q), inertials)])
    bias = np.array(
        [zero + torque for torque in inverse_dynamics(device, Numbers(q), inertials, dict(enumerate(v)), {})]
    )
    worst = 0.0
    for n in range(1000):
        M_kane, forcing = f(q[:, n], v[:, n])
        worst = max(worst, np.abs(M[:, :, n] - M_kane).max() / np.abs(M_kane).max())
        worst = max(worst, np.abs(bias[:, n] + forcing[:, 0]).max() / np.abs(forcing).max())
    assert worst < 1e-9
