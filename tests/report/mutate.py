"""``python -m tests.report.mutate``: put each error of `mutations` into a copy of the tree, and see whether a test fails.

Nothing outside the temporary copy changes. A mutation that no test notices is named, and the exit code is 1.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from tests.report.mutations import MUTATIONS, Mutation

ROOT = Path(__file__).parents[2]
COPIED = ("report", "haptid", "tests")
"""Folders that are copied: the mutated one, the links to it, and the tests, whose place decides what they import."""
COMMAND = (sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header", "--tb", "no")
PASSED, FAILED = 0, 1
"""Exit codes of pytest; any other means that no test could be run."""


def copy_tree(copy: Path) -> None:
    """Copy what a mutation changes or a test is found by, and link all else."""
    for name in COPIED:
        shutil.copytree(ROOT / name, copy / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    for path in ROOT.iterdir():
        if path.name not in COPIED and not path.name.startswith("."):
            (copy / path.name).symlink_to(path)


def test(copy: Path, *files: str) -> int:
    """Run test files of the copy, and return pytest's exit code."""
    paths = [f"tests/report/{name}" for name in files]
    command = (*COMMAND, "-c", "pyproject.toml", "--rootdir", str(copy), *paths)
    return subprocess.run(command, cwd=copy, check=False, capture_output=True).returncode


def is_noticed(copy: Path, mutation: Mutation) -> bool:
    """Say whether a test fails with the mutation in place, and take it out again.

    Raises
    ------
    click.ClickException
        Where the old text does not stand in the file exactly once, or the tests could not be run.
    """
    path = copy / "report" / mutation.file
    text = path.read_text(encoding="utf-8")
    where = f"{mutation.file}, {mutation.name}"
    if text.count(mutation.old) != 1:
        msg = f"{where}: expected the old text once, got it {text.count(mutation.old)} times; adapt tests/report/mutations.py"
        raise click.ClickException(msg)
    path.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")
    try:
        code = test(copy, mutation.test)
    finally:
        path.write_text(text, encoding="utf-8")
    if code not in (PASSED, FAILED):
        msg = f"{where}: expected tests that run, got exit code {code} of pytest; run {mutation.test} by hand"
        raise click.ClickException(msg)
    return code == FAILED


@click.command()
@click.option("--only", default="", help="Mutations of files whose path contains this.")
def main(only: str) -> None:
    """Mutate report/ in a temporary copy, and print how many of the errors the tests notice."""
    chosen = [mutation for mutation in MUTATIONS if only in mutation.file]
    survivors = []
    with TemporaryDirectory() as folder:
        copy = Path(folder)
        copy_tree(copy)
        # A test that fails without any error would notice every one.
        if test(copy, *sorted({mutation.test for mutation in chosen})) != PASSED:
            raise click.ClickException("tests/report: expected tests that pass before any mutation; mend them first")
        for mutation in chosen:
            noticed = is_noticed(copy, mutation)
            click.echo(f"{'noticed ' if noticed else 'SURVIVES'}  {mutation.file}: {mutation.name}")
            if not noticed:
                survivors.append(mutation)
    share = 100 * (1 - len(survivors) / max(len(chosen), 1))
    click.echo(f"{len(chosen) - len(survivors)} of {len(chosen)} noticed ({share:.0f} %)")
    sys.exit(bool(survivors))


if __name__ == "__main__":
    main()
