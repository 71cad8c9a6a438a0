"""All static checks, each run and reported: lint, format, types, import contracts, locked requirements."""

from __future__ import annotations

import subprocess
import sys

import click

CHECKS = {
    "ruff check": ("-m", "ruff", "check", "--output-format", "concise", "."),
    "ruff format": ("-m", "ruff", "format", "--check", "--output-format", "concise", "."),
    "mypy": ("-m", "mypy", "--no-error-summary"),
    "import contracts": (
        "-c",
        "from importlinter.cli import lint_imports_command; lint_imports_command()",
        "--no-logo",
    ),
    "locked requirements": ("-m", "support.installing.supply_chain", "check"),
}


@click.command()
def main() -> None:
    """Run every check; exit 1 where one of them fails."""
    failed = []
    for name, arguments in CHECKS.items():
        done = subprocess.run([sys.executable, *arguments], check=False, capture_output=True, text=True)
        if done.returncode != 0:
            failed.append(name)
            click.echo(f"{done.stdout.strip()}\n{done.stderr.strip()}".strip())
        click.echo(f"{name}: {'failed' if done.returncode else 'passed'}")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
