"""What was found on the torque of one joint: verdict, gaps, and the sentences that tell them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.detect.localise import Map, Region
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.soundness import Soundness
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.closed_loop import ClosedLoop
from haptid.discrepancy.torque_search.search import TorqueSearch
from haptid.fmu_build.building.packaging import Fmu
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.model.effects.effect import Effect, id_of
from haptid.support.linear_algebra import rms
from haptid.support.numbers import plain, with_prefix


@dataclass(frozen=True, slots=True, kw_only=True)
class Remaining:
    """Mean residual torque over position, by direction.

    Parameters
    ----------
    position
        Middles of the bins [rad], shape (n_bins,).
    up, down
        Mean residual torque while the position grows and falls [N m], shape (n_bins,).
    std
        Standard error of these means [N m], shape (n_bins,).
    """

    position: Array
    up: Array
    down: Array
    std: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueFinding:
    """Result for one joint whose torque was scored, as page and JSON show it.

    Parameters
    ----------
    search
        Result of the search.
    gaps
        RMS before and after by ``fit``, ``validate`` and, where there are such runs, ``sealed``.
    regions, maps
        Residual energy of the nominal model, and the regions that hold most of it.
    remaining
        Mean residual torque of the final model over position.
    floor
        RMS of the final model's residual that does not repeat [N m]; None where no position is passed again.
    black_box
        RMS that a table over position and speed leaves of that residual on held-out rows [N m]; None without such rows.
    nominal_loop, final_loop
        Both models refitted and simulated through the recorded controller; None without one.
    fmu
        FMU with the effects of the final model, or None.
    considered
        Number of catalogue effects that were searched.
    wall_s
        Wall time of all stages [s].
    doubted
        Keys of the effects whose names are not certain (`torque_search.certain`, ``soundness``).
    soundness
        What inertia and free simulation say of the final model; None where they were not asked.
    """

    search: TorqueSearch
    gaps: dict[str, Gap]
    regions: tuple[Region, ...]
    maps: tuple[Map, ...]
    remaining: Remaining
    floor: float | None
    black_box: float | None
    nominal_loop: ClosedLoop | None
    final_loop: ClosedLoop | None
    fmu: Fmu | None
    considered: int
    wall_s: float
    doubted: frozenset[str] = frozenset()
    soundness: Soundness | None = None

    @property
    def stability(self) -> Mapping[str, float]:
        """Share of bags of stretches in which an effect keeps its name [1], by its key."""
        return self.search.stability

    @property
    def largest_torque(self) -> float:
        """Largest measured torque [N m] ([N]): the size of the drive, in whose unit residuals stand beside it."""
        return max(float(np.max(np.abs(run.y))) for run in self.search.study.runs)

    @property
    def verdict(self) -> str:
        """Verdict of INTERFACES.

        Names stand alone where they leave no more than does not repeat, on fitted and on held-out runs, or close nearly
        all that the best black box closes and most of what repeats; else they name a part. Where the runs do not tell
        one of them from another effect, they are ambiguous. Where some names are doubted, the others name a part; names
        that are all doubted are no finding, nor are those with which the recorded controller no longer holds the
        simulation near the motion.
        """
        verdict = "ambiguous" if self.search.rivals else "named"
        if self.doubted:
            verdict = "partly_named"
        gap, names = self.gaps["validate"], self.search.final.effects
        if self.all_doubted:
            return "unlisted"
        most = THRESHOLDS.finding.largest_rms_over_torque_noise * max(gap.noise, self.floor or 0.0)
        if self.search.final.left <= most and not self.worsens_position:
            return verdict if names else "nothing_missing"
        if not names or self.worsens_position:
            return "unlisted"
        closed, possible = self.shares
        if possible is None or possible <= 0:
            return "partly_named"
        enough = max(
            THRESHOLDS.torque.least_share_of_black_box * possible,
            THRESHOLDS.torque.least_share_of_repeated * self.repeated_share,
        )
        return verdict if closed >= enough else "partly_named"

    @property
    def all_doubted(self) -> bool:
        """Whether there are names, and none is certain."""
        names = self.search.final.effects
        return bool(self.doubted) and all(e.key in self.doubted for e in names)

    @property
    def worsens_position(self) -> bool:
        """Whether the position through the recorded controller is worse with the named effects, on runs of any use."""
        before, after = self.nominal_loop, self.final_loop
        if before is None or after is None or not self.search.final.effects:
            return False
        most = THRESHOLDS.torque.largest_rms_through_controller
        return any(after.rms[use] > most * before.rms[use] for use in after.rms)

    @property
    def repeated_share(self) -> float:
        """Share of the held-out residual's energy that repeats; where no position is passed again, all may."""
        before = max(self.gaps["validate"].before, np.finfo(float).tiny)
        return max(1.0 - ((self.floor or 0.0) / before) ** 2, 0.0)

    @property
    def shares(self) -> tuple[float, float | None]:
        """Shares of the held-out residual's energy that the named effects and the best black box close."""
        gap = self.gaps["validate"]
        energy = max(gap.before, np.finfo(float).tiny) ** 2
        box = None if self.black_box is None else 1.0 - self.black_box**2 / energy
        return 1.0 - gap.after**2 / energy, box

    @property
    def sentence(self) -> str:
        """Sentence that an engineer reads first."""
        effects = self.search.final.effects
        names = _write_names([e for e in effects if self.worsens_position or e.key not in self.doubted])
        if self.verdict == "nothing_missing":
            told = "Nothing is missing: what is left of the torque does not repeat."
            near = self._near_reversals_sentence
            return told if near is None else f"{told} {near[0].upper()}{near[1:]}: there the filter decides."
        if self.verdict in ("named", "ambiguous"):
            return f"Missing in the model: {names}.{self._soundness_sentences}{self._rivals_sentence} {self._measured}"
        if self.verdict == "unlisted":
            lead = "Something is missing that no effect of the catalogue explains."
            if names:
                lead += f" It is like {names}, but with it the position strays further from the measured one."
            if self.all_doubted and not self.worsens_position:
                lead = f"Something is missing, and no name for it is certain. It is like {_write_names(effects)}."
            return f"{lead}{self._soundness_sentences} {self._measured}"
        doubted = _write_names([e for e in effects if e.key in self.doubted])
        unsure = f" Not certain: {doubted}." if doubted else ""
        unsure += self._soundness_sentences
        return f"Missing in the model: {names}; they explain a part.{unsure}{self._rivals_sentence} {self._measured}"

    @property
    def _soundness_sentences(self) -> str:
        """Sentences on what inertia and free simulation doubt; empty where that is nothing."""
        if self.soundness is None or not (self.soundness.doubted or self.soundness.is_outdone):
            return ""
        told = self.soundness.tell(self.search.final.effects, prismatic=self.search.study.prismatic)
        return told if self.verdict == "unlisted" else f"{told} So no FMU has these effects."

    @property
    def _rivals_sentence(self) -> str:
        """Sentence on what could as well stand in the place of a named effect; empty where there is nothing."""
        places: dict[str, list[str]] = {}
        for rival in self.search.rivals:
            places.setdefault(id_of(rival.replaces), []).append(id_of(rival.key))
        told = [
            f"{' or '.join(dict.fromkeys(others))} could as well stand for {name}" for name, others in places.items()
        ]
        return f" The runs cannot tell: {'; '.join(told)}." if told else ""

    @property
    def _measured(self) -> str:
        """Sentences on what is left, what could be closed, and what does not repeat."""
        gap, unit = self.gaps["validate"], unit_for("N m", [self.search.study.prismatic])
        closed, possible = self.shares
        box = None if possible is None else f"{100 * max(possible, 0.0):.0f} %"
        near = self._near_reversals_sentence
        subject = f"On held-out rows{' away from reversals' if near else ''} the torque's RMS error"
        if self.search.final.effects:
            told = [f"{subject} falls from {plain(gap.before, 3)} to {plain(gap.after, 3)} {unit}"]
            names = f"names close {100 * max(closed, 0.0):.0f} % of its energy"
            told += [] if box is None else [f"{names}, the best black box of position and speed {box}"]
        else:
            told = [f"{subject} is {plain(gap.before, 3)} {unit}; no name closes any of it"]
            told += [] if box is None else [f"the best black box of position and speed closes {box} of its energy"]
        if near is not None:
            told.append(near)
        if self.floor is None:
            told.append("the floor is unknown: one more sweep over the same positions would tell what repeats")
        else:
            told.append(f"{plain(self.floor, 3)} {unit} do not repeat")
        return "; ".join(told) + "." + self._friction_sentence + self._delay_sentence + self._loop_sentence

    @property
    def _near_reversals_sentence(self) -> str | None:
        """What is left of held-out rows near reversals; None where none is left out."""
        final = self.search.final
        near = ~final.study.names(final.study.unseen_rows)
        if not near.any():
            return None
        left = f"{plain(rms(final.unseen[near]), 3)} {unit_for('N m', [self.search.study.prismatic])}"
        return f"near reversals, {100 * float(np.mean(near)):.2g} % of the rows, {left} are left"

    @property
    def _friction_sentence(self) -> str:
        """Sentence on friction that differs from run to run; empty where it does not."""
        told = self.search.study.friction_by_run
        if told is None:
            return ""
        low, high = (choose(told.levels, key=lambda file: told.levels[file]) for choose in (min, max))
        unit = unit_for("N m", [self.search.study.prismatic])
        return (
            f" Friction differs from run to run, from {plain(told.levels[low], 3)} ({low}) to "
            f"{plain(told.levels[high], 3)} ({high}) times the model's: with it the error on held-out rows was "
            f"{plain(told.before, 3)} {unit}, without it {plain(told.after, 3)} {unit}. The joint warms up, or its "
            "load is changed: record runs at one temperature, or the temperature beside them."
        )

    @property
    def _delay_sentence(self) -> str:
        """Sentence on the delay that the torque has behind it; empty without one."""
        delay = self.search.study.delay
        if not delay:
            return ""
        late = "after" if delay > 0 else "before"
        return f" The torque acts {with_prefix(abs(delay), 's', 2)} {late} it is recorded, which no name stands for."

    @property
    def _loop_sentence(self) -> str:
        """Sentence on the position through the recorded controller; empty without one or without unseen runs."""
        before, after = self.nominal_loop, self.final_loop
        if before is None or after is None or "validate" not in after.mean_absolute:
            return ""
        unit = unit_for("rad", [self.search.study.prismatic])
        was, now = (loop.mean_absolute["validate"] for loop in (before, after))
        errors = f"{was:.3g} {unit} before and {now:.3g} {unit} after"
        return (
            f" Simulated through the recorded controller, the position of unseen runs is off by {errors}, on average."
        )


def _write_names(effects: Sequence[Effect]) -> str:
    return " and ".join(f"{e.id} ({e.title})" for e in effects)
