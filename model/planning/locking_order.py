"""Derive the locking order of a device: fewest new unknowns first, then the additional tests that the full model needs.

`Device` comes in, `LockingOrder` goes out. The unknowns of a configuration are the standard parameters that its
equation contains with the locked joints at any posture; the new unknowns of a stage are those that no earlier stage
contains.

1. Derive the full model's rows over π: their span gives the base parameters.
2. Append single joints greedily by the number of their new unknowns.
3. For 2, 3, … free joints, append the configuration with most new unknowns while parameters or combinations of the full
   model are missing and a configuration adds some.

Tam, Kubica & Wang (2005), Fig. 2 and Table I, give the order of one device, derived by hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

from haptid.model.algebra.echelon import Echelon, Row
from haptid.model.device.device import Device
from haptid.model.rigid_body.base_parameters import equation_forms, full_lagrangian, rows
from haptid.model.rigid_body.lagrange import Lagrangian
from haptid.model.rigid_body.locked_dynamics import locked_motion
from haptid.model.rigid_body.standard_parameters import find_contained


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """One configuration of the order.

    Parameters
    ----------
    free
        The free joints.
    contains
        Ids of the standard parameters in its equation.
    new
        Those that no earlier stage contains.
    coefficients
        Number of coefficients the equation has with the locked joints at home.
    rank_home, rank_any
        Number of combinations it determines: with the others at home, and over all postures.
    new_combinations
        Number of combinations (over all postures) that the earlier stages did not determine.
    """

    free: tuple[int, ...]
    contains: frozenset[str]
    new: frozenset[str]
    coefficients: tuple[str, ...]
    rank_home: int
    rank_any: int
    new_combinations: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LockingOrder:
    """Stages in order, and the parameters and combinations of the full model.

    Parameters
    ----------
    stages
        Configurations in the order of their tests.
    needed
        Standard parameters that the full model contains.
    full
        Span of the full model's rows; its rank is the number of base parameters.
    reached_home, reached_any
        Rank of everything the stages determine with the locked joints at home, and over all postures.
    """

    stages: tuple[Stage, ...]
    needed: frozenset[str]
    full: Echelon
    reached_home: int
    reached_any: int


def locking_order(device: Device) -> LockingOrder:
    """Derive the locking order of a device.

    Parameters
    ----------
    device
        Device with n_q joints.

    Returns
    -------
    LockingOrder
        One stage per single joint, then stages of several free joints while they add unknowns or combinations.
    """
    lagrangian = full_lagrangian(device)
    joints = tuple(range(len(device.joints)))
    everything = rows(equation_forms(lagrangian, joints))
    full, needed = Echelon.of(everything), find_contained(device, everything)
    builder = _Builder(device, lagrangian)
    left = list(joints)
    while left:
        # fewest new unknowns, then fewest unknowns in all, then the highest number
        chosen = min(left, key=lambda j: (len(builder.new((j,))), len(builder.contains((j,))), -j))
        builder.add((chosen,))
        left.remove(chosen)
    for size in range(2, len(joints) + 1):
        builder.extend(size, needed, full)
    return LockingOrder(
        stages=tuple(builder.stages),
        needed=needed,
        full=full,
        reached_home=builder.home.rank,
        reached_any=builder.any.rank,
    )


class _Builder:
    """The stages so far, with the spans that they determine at home (`home`) and over all postures (`any`)."""

    def __init__(self, device: Device, lagrangian: Lagrangian) -> None:
        self.device, self.lagrangian = device, lagrangian
        self.stages: list[Stage] = []
        self.known: frozenset[str] = frozenset()
        self.home, self.any = Echelon.of(()), Echelon.of(())
        self._rows: dict[tuple[int, ...], list[Row]] = {}
        self._contains: dict[tuple[int, ...], frozenset[str]] = {}

    def rows(self, free: tuple[int, ...]) -> list[Row]:
        """Return the rows of a configuration over all postures."""
        if free not in self._rows:
            self._rows[free] = rows(equation_forms(self.lagrangian, free))
        return self._rows[free]

    def contains(self, free: tuple[int, ...]) -> frozenset[str]:
        """Return the standard parameters that a configuration's equation contains."""
        if free not in self._contains:
            self._contains[free] = find_contained(self.device, self.rows(free))
        return self._contains[free]

    def new(self, free: tuple[int, ...]) -> frozenset[str]:
        """Return the standard parameters of a configuration that no stage so far contains."""
        return self.contains(free) - self.known

    def gain(self, free: tuple[int, ...]) -> int:
        """Return the number of identifiable combinations that a configuration would add, over all postures."""
        return self.any.extend(self.rows(free)).rank - self.any.rank

    def add(self, free: tuple[int, ...]) -> None:
        """Append a stage."""
        dynamics = locked_motion(self.device, free)
        at_home = [coefficient.exact for coefficient in dynamics.coefficients]
        before, self.any = self.any.rank, self.any.extend(self.rows(free))
        self.home = self.home.extend(at_home)
        stage = Stage(
            free=free,
            contains=self.contains(free),
            new=self.new(free),
            coefficients=tuple(coefficient.id for coefficient in dynamics.coefficients),
            rank_home=Echelon.of(at_home).rank,
            rank_any=Echelon.of(self.rows(free)).rank,
            new_combinations=self.any.rank - before,
        )
        self.stages.append(stage)
        self.known |= stage.contains

    def extend(self, size: int, needed: frozenset[str], full: Echelon) -> None:
        """Append stages of several free joints while the full model needs them and they add unknowns or combinations.

        Parameters
        ----------
        size
            Number of free joints.
        needed
            Standard parameters that the full model contains.
        full
            Span of the full model's rows.
        """
        while needed - self.known or self.any.rank < full.rank:
            tests = combinations(range(len(self.device.joints)), size)
            best = max(tests, key=self._worth)
            if not self.new(best) and not self.gain(best):
                return
            self.add(best)

    def _worth(self, free: tuple[int, ...]) -> tuple[int, int, int]:
        return len(self.new(free)), self.gain(free), -len(self.contains(free))
