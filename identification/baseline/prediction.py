"""Signals that model and plain model predict for a run, for figures: `Compared` and `Run` in, `Prediction` out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.figures import simulate_freely
from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """Predicted signals of one run.

    Parameters
    ----------
    file, use
        File of the run and its use.
    joints, prismatic
        Numbers of the free joints, and whether each is prismatic: then rad and N m below are m and N.
    torque_t
        Times of the torque [s], shape (n,).
    torque
        Measured torque, filtered as the motion [N m], shape (n, n_joints).
    computed
        Torque that the measured motion needs [N m] by ``model`` or ``baseline``, shape (n, n_joints) each.
    position_t
        Times of the position [s], shape (n_scored,).
    position
        Measured position [rad], shape (n_scored, n_joints).
    simulated
        Position of a free simulation from the measured start [rad] by model, shape (n_scored, n_joints) each.
    """

    file: str
    use: str
    joints: tuple[int, ...]
    prismatic: tuple[bool, ...]
    torque_t: Array
    torque: Array
    computed: Mapping[str, Array]
    position_t: Array
    position: Array
    simulated: Mapping[str, Array]


def predict_run(compared: Compared, run: Run) -> Prediction:
    """Compute torque and position of a run by both models.

    Parameters
    ----------
    compared
        Both models.
    run
        One of their runs.

    Returns
    -------
    Prediction
    """
    # The width of the figures: curves and figures then show the same residual.
    motion, states = filter_run(run, compared.width), filter_run(run, compared.width_of_states)
    inside = motion.interior
    return Prediction(
        file=run.file,
        use=run.use,
        joints=run.free_joints,
        prismatic=tuple(run.prismatic),
        torque_t=motion.t[inside],
        torque=motion.torque[inside],
        computed={name: model.recorded_torque(motion)[inside] for name, model in compared.models.items()},
        position_t=run.t[run.score_from :],
        position=run.y[run.score_from :],
        simulated={name: simulate_freely(model, run, states) for name, model in compared.models.items()},
    )


def predict_unseen(compared: Compared | None) -> Prediction | None:
    """Predict the longest run that no fit saw.

    Parameters
    ----------
    compared
        Both models with their runs; None where the configuration has no plain model.

    Returns
    -------
    Prediction or None
        None without a plain model or an unseen run.
    """
    if compared is None or compared.baseline is None:
        return None
    unseen = [run for run in compared.runs if run.use == "validate"]
    if not unseen:
        return None
    return predict_run(compared, max(unseen, key=lambda run: run.t[-1] - run.t[run.score_from]))
