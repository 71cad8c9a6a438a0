"""The thresholds of the search: what is accepted, what counts as significant, how much is tried.

Each room has a dataclass of its own in the module of its name. A place of use reads ``THRESHOLDS.detect.random_draws``.
`docs/theory/missing_physics.md` gives the symbol of each number that its formulas use.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from haptid.discrepancy.thresholds.candidate import CandidateThresholds
from haptid.discrepancy.thresholds.detect import DetectThresholds
from haptid.discrepancy.thresholds.finding import FindingThresholds
from haptid.discrepancy.thresholds.fit import FitThresholds
from haptid.discrepancy.thresholds.resonance import ResonanceThresholds
from haptid.discrepancy.thresholds.search import SearchThresholds
from haptid.discrepancy.thresholds.study import StudyThresholds
from haptid.discrepancy.thresholds.torque import TorqueThresholds
from haptid.discrepancy.thresholds.unnamed import UnnamedThresholds
from haptid.discrepancy.thresholds.verdict import VerdictThresholds


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Thresholds of all rooms, bottom up."""

    study: StudyThresholds = field(default_factory=StudyThresholds)
    """Bounds of parameters, inner steps and the budget."""
    fit: FitThresholds = field(default_factory=FitThresholds)
    """Starts, noise, scatter, unseen runs and standard errors."""
    detect: DetectThresholds = field(default_factory=DetectThresholds)
    """Omnibus test, score tests and where the residual lies."""
    torque: TorqueThresholds = field(default_factory=TorqueThresholds)
    """The search in the torque of runs under position control."""
    resonance: ResonanceThresholds = field(default_factory=ResonanceThresholds)
    """First guesses of resonant effects from frequency responses."""
    candidate: CandidateThresholds = field(default_factory=CandidateThresholds)
    """When a model leaves only noise, and when an effect has earned its place."""
    search: SearchThresholds = field(default_factory=SearchThresholds)
    """How many effects go on from one step to the next."""
    unnamed: UnnamedThresholds = field(default_factory=UnnamedThresholds)
    """The missing torque as a function, and its formula."""
    verdict: VerdictThresholds = field(default_factory=VerdictThresholds)
    """Names, alternatives and the next experiment."""
    finding: FindingThresholds = field(default_factory=FindingThresholds)
    """What is said of the gap before and after."""


THRESHOLDS = Thresholds()
"""The values that every command uses."""
