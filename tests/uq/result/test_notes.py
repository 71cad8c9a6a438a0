"""What the reader of a posterior is told."""

from __future__ import annotations

from types import SimpleNamespace

from haptid.identification.result.outcome import Outcome
from haptid.uq.job.sample import notes_of


def test_what_forbids_to_use_a_posterior_is_said_first_and_nothing_twice():
    posterior = SimpleNamespace(shortened="4 ensembles in place of 8")
    fit = SimpleNamespace(notes=("a note",), warnings=("a warning",), outcome=Outcome.CONVERGED)
    subject = SimpleNamespace(fit=fit, source="made here")
    notes = notes_of(posterior, subject, early="few rows", doubts=("the model misfits",))
    assert notes[:-1] == ("few rows", "the model misfits", "4 ensembles in place of 8.", "a note", "a warning")
    assert notes[-1].startswith("The fit it starts from, made here: ")
