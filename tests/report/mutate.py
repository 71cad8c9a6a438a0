"""``python -m tests.report.mutate``: put each error of `mutations` into a copy of the tree, and run the tests there.

Nothing outside the temporary copy changes. A mutation that no test notices is named, and the exit code is 1.
"""

from __future__ import annotations

import importlib
import multiprocessing
import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import pytest

from tests.report.mutations import MUTATIONS, Mutation

ROOT = Path(__file__).parents[2]
COPIED = ("report", "haptid", "tests")
"""Folders that are copied: the mutated one, the links to it, and the tests, whose place decides what they import."""
OPTIONS = ("-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--no-header", "--tb", "no", "-c", "pyproject.toml")
PASSED, FAILED = 0, 1
"""Exit codes of pytest; any other means that no test could be run."""


def copy_tree(copy: Path) -> None:
    """Copy what a mutation changes or a test is found by, and link all else."""
    for name in COPIED:
        shutil.copytree(ROOT / name, copy / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    for path in ROOT.iterdir():
        if path.name not in COPIED and not path.name.startswith("."):
            (copy / path.name).symlink_to(path)


def import_from(copy: Path) -> None:
    """Import from the copy all that the tests need but the pages and the tests: the forked processes share it."""
    sys.dont_write_bytecode = True  # two mutations of one second and one length would share their bytecode
    os.chdir(copy)
    sys.path[:] = [str(copy), *(path for path in sys.path if path and Path(path) != ROOT)]
    for name in sorted({mutation.test for mutation in MUTATIONS}):
        importlib.import_module(f"tests.report.{name.removesuffix('.py').replace('/', '.')}")
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests" or name.startswith("haptid.report")]:
        del sys.modules[name]


def run_tests(copy: Path, files: tuple[str, ...]) -> None:
    """Run test files of the copy, and end the process with pytest's exit code."""
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        sys.stdout = sys.stderr = nowhere
        code = pytest.main([*OPTIONS, "--rootdir", str(copy), *(f"tests/report/{name}" for name in files)])
        os._exit(code)


def fork_tests(copy: Path, *files: str) -> int | None:
    """Run test files of the copy in a process of their own, and return pytest's exit code."""
    process = multiprocessing.get_context("fork").Process(target=run_tests, args=(copy, files))
    process.start()
    process.join()
    return process.exitcode


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
    count = text.count(mutation.old)
    if count != 1:
        msg = f"{where}: expected the old text once, got it {count} times; adapt tests/report/mutations.py"
        raise click.ClickException(msg)
    path.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")
    try:
        code = fork_tests(copy, mutation.test)
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
        import_from(copy)
        # A test that fails without any error would notice every one.
        if fork_tests(copy, *sorted({mutation.test for mutation in chosen})) != PASSED:
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
