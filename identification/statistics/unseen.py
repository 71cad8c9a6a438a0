"""What an unseen run leaves beyond what was left open: `Simulator`, `Fit`, `Run` and its score in, RMS over noise out.

The initial state of a run that no fit saw is told by its first rows alone, and the parameters have a covariance. A
joint that swings far turns both into errors of several times the noise late in the run, of a model that is right. What
they explain is no alarm: with δ the initial state and η the parameters in their standard deviations,

    min over δ, η of  ‖r − J₀ δ − J_θ L η‖² + ‖η‖² ,   L Lᵀ = covariance of the parameters,

r the residual over the noise. A model that lacks something leaves more than noise at the minimum, too.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.problem.initial_states import start_of
from haptid.identification.result.fit import Fit, RunScore
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Run
from haptid.support.linear_algebra import rms


def rms_beyond_left_open(simulator: Simulator, found: Fit, run: Run, score: RunScore) -> float:
    """Compute the RMS over the noise that neither initial state nor parameters explain.

    Parameters
    ----------
    simulator
        Simulator of the fit.
    found
        Fit with the covariance of its free parameters.
    run
        Run that no fit saw.
    score
        Score of this run, with the initial state that it was simulated from.

    Returns
    -------
    float
        RMS over the noise of the scored rows at the minimum; that of the score where the simulation has no finite
        sensitivities.
    """
    made = simulator.simulate(found.theta, run, x0=score.x0, sensitivities=True)
    joints = run.y.shape[1]
    if made.dy_dx0 is None or made.dy_dtheta is None:
        return score.over_noise
    sigma = run.sensor_std
    states = list(start_of(simulator.equations, run).states)
    ids = [q.id for q in found.equations.parameters]
    places = [ids.index(id) for id in found.free]
    values, vectors = np.linalg.eigh(found.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    start = made.dy_dx0[run.scored][:, :joints][..., states] / sigma[:, None]
    parameters = made.dy_dtheta[run.scored][:, :joints][..., places] / sigma[:, None] @ root
    r = ((run.y - made.y[:, :joints])[run.scored] / sigma).ravel()
    J = np.concatenate([start, parameters], axis=-1).reshape(r.size, -1)
    if not (np.isfinite(J).all() and np.isfinite(r).all()):
        return score.over_noise
    held = np.eye(J.shape[1])[len(states) :]
    size = np.maximum(np.linalg.norm(J, axis=0), np.finfo(float).tiny)  # columns of a state may be of any unit
    best = np.linalg.lstsq(np.concatenate([J, held]) / size, np.concatenate([r, np.zeros(len(held))]), rcond=None)[0]
    return rms(r - J @ (best / size))
