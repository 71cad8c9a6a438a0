"""The list of errors fits the pages: each old text stands exactly once, and the changed file is still Python."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.report.mutations import MUTATIONS

REPORT = Path(__file__).parents[2] / "report"


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda m: f"{m.file}: {m.name}")
def test_an_error_can_be_put_into_its_place(mutation):
    text = (REPORT / mutation.file).read_text(encoding="utf-8")
    assert text.count(mutation.old) == 1
    assert compile(text.replace(mutation.old, mutation.new), mutation.file, "exec")
    assert (Path(__file__).parent / mutation.test).is_file()
