"""A joint with a drive: kernel and FMU against SciPy, sensitivities, and parameters found again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from haptid.fmu_build.building.packaging import build_fmu
from haptid.identification.fit.fit_runs import JointTest, fit_runs
from haptid.identification.problem.options import FitOptions
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.registry import catalogue
from haptid.model.equations.drive import Controller, Drive
from haptid.model.equations.equations import Equations
from haptid.model.joint.drive_terms import drive_inputs
from haptid.model.joint.locked_joint import joint_equations

TRUTH = {
    "inertia": 0.006, "gravity_cos": 0.0, "gravity_sin": 0.48, "Kp": 1.0, "Ks": 0.0, "epos": 0.0, "sigma0": 20.0,
    "sigma1": 0.05, "sigma2": 0.01, "vs": 0.1, "Fs": 0.06, "Fc": 0.05, "torque_constant": 0.4, "resistance_ohm": 3.0,
    "controller_limit": 0.5, "controller_derivative_gain": 0.02, "controller_integral_gain": 0.3,
}  # fmt: skip
T = np.arange(0.0, 6.0, 0.005)
LOOPS = {kind: Controller(kind=kind, gain=0.6, limit=0.5) for kind in ("p", "pd", "pid")}
DRIVES = (
    Drive(kind="current"),
    Drive(kind="voltage"),
    Drive(kind="duty"),
    Drive(kind="torque", controller=LOOPS["p"]),
    Drive(kind="voltage", controller=LOOPS["pd"]),
    Drive(kind="duty", controller=LOOPS["p"]),
    Drive(kind="duty", controller=LOOPS["pid"]),
)
COLUMNS = {
    "current": 1.0 * np.sin(3 * T) + 0.5 * np.sin(1.3 * T),
    "voltage": 4.0 * np.sin(3 * T) + 2.0 * np.sin(1.3 * T),
    "duty": 0.5 * np.sin(3 * T) + 0.3 * np.sin(1.3 * T),
    "reference": 1.2 * np.sin(2.5 * T),
    "supply": 7.4 + 0.2 * np.sin(0.7 * T),
    "enabled": ((T < 3.0) | (T > 3.4)).astype(float),
    "controller_gain": np.full(T.size, 0.6),
}


def equations_of(drive: Drive, **fixed: float) -> Equations:
    equations = joint_equations(0, drive=drive)
    changes = {
        q.id: {"initial": TRUTH[q.id], "fixed": q.fixed or q.id in fixed, "lower": min(q.lower, TRUTH[q.id])}
        for q in equations.parameters
    }
    return equations.with_parameters(changes)


def recorded(drive: Drive, y: Array | None = None) -> Run:
    return Run(
        file="a.csv", free_joints=(0,), t=T, u=np.zeros((T.size, 1)), y=np.zeros((T.size, 1)) if y is None else y,
        noise=np.array([1e-4]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
        drive_inputs={x.id: COLUMNS[x.id] for x in drive_inputs(drive)},
    )  # fmt: skip


def torque_of(drive: Drive, row: dict[str, float], q: float, v: float, integral: float) -> float:
    """Return the torque by formulas of its own."""
    p = TRUTH
    if drive.controller is None:
        command = row[drive.kind]
    else:
        command = row["controller_gain"] * (row["reference"] - q)
        command -= p["controller_derivative_gain"] * v if drive.controller.kind != "p" else 0.0
        command += p["controller_integral_gain"] * integral if drive.controller.kind == "pid" else 0.0
        command = float(np.clip(command, -p["controller_limit"], p["controller_limit"]))
    if row["enabled"] == 0.0:
        return 0.0
    if drive.kind == "torque":
        return command
    if drive.kind == "current":
        return p["torque_constant"] * command
    volts = command * row["supply"] if drive.kind == "duty" else command
    return p["torque_constant"] * (volts - p["torque_constant"] * v) / p["resistance_ohm"]


def truth_of(drive: Drive) -> Array:
    """Return the positions by SciPy, row by row, inputs held between rows."""
    p, state, positions = TRUTH, np.zeros(4), [0.0]

    def slope(row: dict[str, float]) -> Callable[[float, Array], list[float]]:
        def rates(_: float, x: Array) -> list[float]:
            q, v, z, integral = x
            g = p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((v / p["vs"]) ** 2))
            dz = v - p["sigma0"] * abs(v) / g * z
            friction = p["sigma0"] * z + p["sigma1"] * dz + p["sigma2"] * v
            torque = torque_of(drive, row, q, v, integral)
            return [v, (torque - p["gravity_sin"] * np.sin(q) - friction) / p["inertia"], dz,
                    row["enabled"] * (row["reference"] - q)]  # fmt: skip

        return rates

    for k in range(T.size - 1):
        row = {name: float(column[k]) for name, column in COLUMNS.items()}
        solved = solve_ivp(slope(row), (T[k], T[k + 1]), state, method="LSODA", rtol=1e-9, atol=1e-11)
        state = solved.y[:, -1]
        positions.append(state[0])
    return np.array(positions)[:, None]


@pytest.mark.parametrize("drive", DRIVES, ids=lambda d: f"{d.kind}_{d.controller.kind if d.controller else 'open'}")
def test_the_kernel_agrees_with_scipy(drive: Drive):
    equations, run = equations_of(drive), recorded(drive)
    theta = np.array([q.initial for q in equations.parameters])
    y = KernelSimulator.of(equations).with_step(2e-4).simulate(theta, run).y
    assert np.max(np.abs(y - truth_of(drive))) < 1e-5 * np.ptp(y)


@pytest.mark.parametrize("drive", [Drive(kind="voltage"), DRIVES[5]], ids=["open", "closed"])
def test_the_fmu_agrees_with_scipy(drive: Drive, tmp_path: Path):
    equations, run = equations_of(drive), recorded(drive)
    fmu = build_fmu(equations, tmp_path / "driven.fmu", kind="native", identification=True)
    theta = np.array([q.initial for q in equations.parameters])
    y = FmuSimulator.of(fmu, equations).with_step(2e-4).simulate(theta, run).y
    assert np.max(np.abs(y - truth_of(drive))) < 1e-5 * np.ptp(y)


@pytest.mark.parametrize("drive", DRIVES[1:], ids=lambda d: f"{d.kind}_{d.controller.kind if d.controller else 'open'}")
def test_sensitivities_are_those_of_differences(drive: Drive):
    equations, run = equations_of(drive), recorded(drive)
    theta, simulator = np.array([q.initial for q in equations.parameters]), KernelSimulator.of(equations)
    exact = simulator.simulate(theta, run, sensitivities=True).dy_dtheta
    assert exact is not None
    for id in ("inertia", "torque_constant", "resistance_ohm", "gravity_sin", "controller_limit"):
        names = [q.id for q in equations.parameters]
        if id in names:
            k = names.index(id)
            step = 1e-6 * theta[k] * np.eye(theta.size)[k]
            ahead, behind = simulator.simulate(theta + step, run).y, simulator.simulate(theta - step, run).y
            difference = (ahead - behind)[:, 0] / (2e-6 * theta[k])
            assert np.max(np.abs(exact[:, 0, k] - difference)) < 2e-3 * np.max(np.abs(difference)) + 1e-7


def test_an_effect_of_the_torque_takes_that_of_the_drive():
    effect = catalogue()["load_dependent_friction:motor"]
    equations = joint_equations(0, drive=DRIVES[5], effects=[effect])
    used = {s for f in (*equations.rhs, *equations.rates) for s in f.free_symbols}
    assert {x.symbol for x in equations.inputs} <= used


@pytest.mark.parametrize("drive", [Drive(kind="voltage"), DRIVES[5]], ids=["open", "closed"])
def test_the_drive_is_found_again_where_gravity_is_known(drive: Drive):
    known = dict.fromkeys(("gravity_cos", "gravity_sin", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs"), 0.0)
    equations, noise = equations_of(drive, **known), np.random.default_rng(3).normal(0.0, 1e-4, (T.size, 1))
    run = recorded(drive, truth_of(drive) + noise)
    start = tuple(q.initial if q.fixed else 1.2 * q.initial for q in equations.parameters)
    test = JointTest(equations=equations, build=KernelSimulator.of, runs=(run,))
    found = fit_runs(test, options=FitOptions(starts=1, start=start))
    values = found.fit.values
    for id, tolerance in (("inertia", 0.02), ("torque_constant", 0.02), ("resistance_ohm", 0.03), ("Fc", 0.03)):
        assert values[id] == pytest.approx(TRUTH[id], rel=tolerance)
    figures = found.compared.figures["a.csv", "fit"]
    if drive.is_closed:
        closed = figures["model"].closed_rmse
        assert closed is not None
        assert closed[0] < 3e-4
        assert figures["baseline"].as_json()["closed_rmse"] > closed[0]
    else:
        # From the torque along the measured motion, whose back-EMF is held from row to row, it was 100 times the fit's.
        assert figures["model"].closed_rmse is None
        assert figures["model"].free_rmse[0] < 3e-4
