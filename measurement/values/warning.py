"""Warnings about campaigns, and how commands print them: one line each on stderr."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import click


class CampaignWarning(UserWarning):
    """Something in a campaign that the user should know and that stops nothing."""


def warn(message: str) -> None:
    """Issue a `CampaignWarning` of one line."""
    warnings.warn(" ".join(message.split()), CampaignWarning, stacklevel=3)


@contextmanager
def warnings_on_stderr() -> Iterator[None]:
    """Print each `CampaignWarning` raised inside as ``warning: …`` on stderr; other warnings go their usual way."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", CampaignWarning)
        try:
            yield
        finally:
            ours = [str(item.message) for item in caught if issubclass(item.category, CampaignWarning)]
            for message in dict.fromkeys(ours):
                click.echo(f"warning: {message}", err=True)
    for item in caught:
        if not issubclass(item.category, CampaignWarning):
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
