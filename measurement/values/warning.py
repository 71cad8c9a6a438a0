"""`CampaignWarning`, and the context in which commands print such warnings: one line each on stderr."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import click


class CampaignWarning(UserWarning):
    """Warn of a fault in a campaign with which a command still goes on."""


def warn(message: str) -> None:
    """Issue a `CampaignWarning`; line breaks in ``message`` become blanks.

    Parameters
    ----------
    message
        Where, and what is doubtful.
    """
    warnings.warn(" ".join(message.split()), CampaignWarning, stacklevel=3)


@contextmanager
def warnings_on_stderr(renamed: tuple[str, str] = ("", "")) -> Iterator[None]:
    """Print each `CampaignWarning` raised inside as ``warning: …`` on stderr, also where an error ends the block.

    A sentence that was issued several times is printed once. Other warnings are issued again after the block.

    Parameters
    ----------
    renamed
        Name of a folder that no user knows, such as a draft's, and the one that stands for it in the lines.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", CampaignWarning)
        try:
            yield
        finally:
            ours = [str(item.message) for item in caught if issubclass(item.category, CampaignWarning)]
            for message in dict.fromkeys(ours):
                click.echo(f"warning: {message.replace(*renamed) if renamed[0] else message}", err=True)
    for item in caught:
        if not issubclass(item.category, CampaignWarning):
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
