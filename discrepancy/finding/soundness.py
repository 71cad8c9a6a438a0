"""Whether a model with named effects is still one of the machine: nominal and final `TorqueFit` in, `Soundness` out.

Named effects may explain a torque and leave the rigid body no sense: then whatever the model is used for goes wrong.
Two things tell, beside the position through a recorded controller: the inertia, and the free simulation of unseen runs.
The latter is held against the nominal model of the search and against the identified model, which was fitted to the
position where that was possible.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.closed_loop import ClosedLoop
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque.free_simulation import free_rms
from haptid.discrepancy.torque_search.rigid_body import INERTIA, find_blamed, find_movers, is_far, tells_inertia
from haptid.measurement.values.units import unit_for
from haptid.model.effects.effect import Effect
from haptid.support.numbers import plain


@dataclass(frozen=True, slots=True, kw_only=True)
class Soundness:
    """What inertia and free simulation say of a model with named effects.

    Parameters
    ----------
    inertia
        Inertia of the nominal model and with the effects [kg m²], or [kg].
    free
        RMS error of the position of unseen runs in free simulation [rad], or [m], with both models; None where they
        were not simulated.
    movers
        Keys of the effects that move the inertia too far.
    worsening
        Keys of the effects with which the free simulation is clearly worse.
    known_free
        RMS error of the same kind with the identified model; None where there is none.
    """

    inertia: tuple[float, float]
    free: tuple[float, float] | None
    movers: frozenset[str] = frozenset()
    worsening: frozenset[str] = frozenset()
    known_free: float | None = None

    @property
    def doubted(self) -> frozenset[str]:
        """Keys of the effects that either doubts."""
        return self.movers | self.worsening

    @property
    def is_outdone(self) -> bool:
        """Whether the identified model simulates unseen runs far better than the model with the effects."""
        if self.free is None or self.known_free is None:
            return False
        return self.free[1] > THRESHOLDS.torque.largest_rms_of_free_simulation * self.known_free

    def tell(self, effects: Sequence[Effect], *, prismatic: bool) -> str:
        """Say what doubts the effects.

        Parameters
        ----------
        effects
            Effects of the model.
        prismatic
            Whether the joint is prismatic, for the units.

        Returns
        -------
        str
            One sentence each, with a space before; empty where nothing doubts them.
        """
        told = ""
        if self.movers:
            unit = unit_for("kg m^2", [prismatic])
            before, after = (plain(value) for value in self.inertia)
            told += (
                f" With {_ids(effects, self.movers)} the inertia would be {after} {unit} instead of {before} {unit}."
            )
        if self.worsening and self.free is not None:
            unit = unit_for("rad", [prismatic])
            before, after = (f"{value:.3g} {unit}" for value in self.free)
            told += (
                f" With {_ids(effects, self.worsening)} a free simulation of unseen runs misses the position by {after}"
                f" instead of {before} RMS."
            )
        if self.is_outdone and self.free is not None and self.known_free is not None:
            unit = unit_for("rad", [prismatic])
            told += (
                f" A free simulation of unseen runs with {_ids(effects, frozenset(e.key for e in effects))} misses the"
                f" position by {self.free[1]:.3g} {unit} RMS, the identified model by {self.known_free:.3g} {unit}: use"
                " that one."
            )
        return told

    def as_json(self) -> dict[str, Any]:
        """Convert to ``soundness`` of the finding's JSON.

        Returns
        -------
        dict
            ``inertia`` and ``free_simulation_rms`` before and after, each with the keys of the effects that it doubts;
            ``identified`` is that of the identified model, None where there is none.
        """
        free = None
        if self.free is not None:
            before, after = (value if math.isfinite(value) else None for value in self.free)
            free = {"before": before, "after": after, "doubts": sorted(self.worsening), "identified": self.known_free}
        inertia = {"before": self.inertia[0], "after": self.inertia[1], "doubts": sorted(self.movers)}
        return {"inertia": inertia, "free_simulation_rms": free}


def judge_soundness(
    base: TorqueFit,
    final: TorqueFit,
    nominal_loop: ClosedLoop | None,
    final_loop: ClosedLoop | None,
    known_free: float | None = None,
) -> Soundness:
    """Judge a model by its inertia and its free simulation of unseen runs.

    Parameters
    ----------
    base, final
        Nominal model, and the model with the named effects.
    nominal_loop, final_loop
        Both refitted through the recorded controller; None without one.
    known_free
        RMS error of the position of unseen runs in free simulation [rad], or [m], with the identified model; None where
        there is none.

    Returns
    -------
    Soundness
        With the inertia of the refit through the controller where that is the one that is far.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    every = frozenset(effect.key for effect in final.effects)
    inertia, movers = (base.values[INERTIA], final.values[INERTIA]), find_movers(base, final)
    loops = None if nominal_loop is None or final_loop is None else (nominal_loop.values, final_loop.values)
    if every and not movers and loops is not None and _is_far_in_loop(base, final, *loops):
        # No fit through the controller without each of them tells which one it is.
        inertia, movers = (loops[0][INERTIA], loops[1][INERTIA]), every
    asked = bool(every) and tells_inertia(base)
    before, after = (free_rms(model) if asked else None for model in (base, final))
    if before is None or after is None:
        return Soundness(inertia=inertia, free=None, movers=movers)
    most = THRESHOLDS.torque.largest_rms_of_free_simulation * before
    worsening = find_blamed(final, lambda without: _is_within(free_rms(without), most)) if after > most else frozenset()
    return Soundness(inertia=inertia, free=(before, after), movers=movers, worsening=worsening, known_free=known_free)


def _is_far_in_loop(base: TorqueFit, final: TorqueFit, before: Mapping[str, float], after: Mapping[str, float]) -> bool:
    """Say whether an inertia that was refitted through the controller is far from both nominal ones.

    The refits have no covariance: the errors are those of the fits to the torque.
    """
    if base.std[INERTIA] == 0.0:
        return False
    error = math.hypot(base.std[INERTIA], final.std[INERTIA])
    return all(is_far(nominal[INERTIA], after[INERTIA], error) for nominal in (base.values, before))


def _is_within(value: float | None, most: float) -> bool:
    return value is not None and value <= most


def _ids(effects: Sequence[Effect], keys: frozenset[str]) -> str:
    return " and ".join(dict.fromkeys(e.id for e in effects if e.key in keys))
