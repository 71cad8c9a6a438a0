"""A stopped sampling does not choose the noise model again, and what it goes on with has the same bits."""

from dataclasses import replace

import numpy as np
import pytest

from haptid.uq.density.forward import EachForward, kernel_of
from haptid.uq.prediction.stored_choice import FILE
from haptid.uq.result import infer as infer_module
from haptid.uq.result.infer import InferOptions, infer
from haptid.uq.sampling.sampling import SamplingOptions
from tests.uq.uq_cases import make_run

OPTIONS = InferOptions(
    sampling=SamplingOptions(ensembles=2, chunk=4, burn=4, pilot=0, longest=4), stored=8, predicted=16, short=True
)


@pytest.fixture
def ask(equations, runs, tmp_path, monkeypatch):
    """Return a function that infers in one folder, and the calls of the choice."""
    unseen = make_run(equations, omega=3.5, seed=40, s=0.01, use="validate")
    theta = np.array([q.initial for q in equations.parameters])
    compared, asked = infer_module.compare, []
    monkeypatch.setattr(infer_module, "compare", lambda *a, **k: asked.append(1) or compared(*a, **k))

    def infer_here(options=OPTIONS, **more):
        return infer(kernel_of(equations), (*runs, unseen), theta, options, joint=4, folder=tmp_path, **more)

    return infer_here, asked


@pytest.mark.parametrize("through", ["kernel", "any simulator"])
def test_a_noise_model_is_chosen_once(ask, equations, through):
    infer_here, asked = ask
    more = {} if through == "kernel" else {"forward": EachForward(simulator=kernel_of(equations))}
    first, second = infer_here(**more), infer_here(**more)
    assert len(asked) == 1
    assert second.chosen.model == first.chosen.model
    assert [(s.model, s.score) for s in second.candidates] == [(s.model, s.score) for s in first.candidates]
    assert second.mode.density.forward == first.mode.density.forward
    np.testing.assert_array_equal(second.sample.chain, first.sample.chain)
    np.testing.assert_array_equal(second.run_log_density, first.run_log_density)
    np.testing.assert_array_equal(second.bands[-1].median, first.bands[-1].median)


@pytest.mark.long
def test_a_choice_of_something_else_or_a_damaged_one_is_made_again(ask, tmp_path):
    infer_here, asked = ask
    infer_here()
    infer_here(replace(OPTIONS, noise_given=False))
    assert len(asked) == 2
    (tmp_path / FILE).write_bytes((tmp_path / FILE).read_bytes()[:100])
    infer_here()
    assert len(asked) == 3
