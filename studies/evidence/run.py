"""Write pages and README lines of the blind studies from the ledger: ``python -m studies.evidence.run``.

It computes and works through nothing; the tests compare.
"""

from __future__ import annotations

import click

from docs.parts.tables import with_parts
from haptid.report.common.style import png
from haptid.support.command import exit_codes
from haptid.support.files.files import write_bytes, write_text
from studies.blind.picture import confusion_picture
from studies.blind.score import confusion
from studies.evidence.pages import PICTURE, pages, readme_text
from studies.evidence.pools import read_studies
from studies.ledger.entries import LEDGER, OWN
from studies.ledger.generator import ROOT

README = ROOT / "README.md"
PART, SCRIPT = "blind studies", "studies/evidence/run.py"


@click.command(help=__doc__)
@exit_codes
def main() -> None:
    """Write them all."""
    studies = read_studies()
    for name, text in pages(studies).items():
        write_text(LEDGER.parent / name, text)
        click.echo(f"written: {name}")
    own = [study for study in studies if study.entry["truth"] == OWN]
    cases = [outcome for study in own for outcome in study.cases]
    left_out = [outcome for study in own for outcome in study.left_out]
    write_bytes(LEDGER.parent / PICTURE, png(confusion_picture(confusion(cases), confusion(left_out))))
    readme = README.read_text(encoding="utf-8")
    write_text(README, with_parts(readme, {PART: readme_text(studies)}, SCRIPT))


if __name__ == "__main__":
    main()
