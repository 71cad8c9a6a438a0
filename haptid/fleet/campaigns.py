"""The campaigns of a fleet: folders in, names and digests of their files out."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from haptid.support.errors import InputError

DESCRIPTION = "campaign.toml"


def campaigns_in(folders: Sequence[Path]) -> dict[str, Path]:
    """Find the campaigns in folders.

    Parameters
    ----------
    folders
        Campaigns, or folders that hold campaigns.

    Returns
    -------
    dict
        Folder of each campaign by the name of the device, which is the folder's name.

    Raises
    ------
    InputError
        Where a folder holds no campaign, or two campaigns have the same name.
    """
    found: dict[str, Path] = {}
    for folder in folders:
        campaigns = [folder] if (folder / DESCRIPTION).is_file() else _campaigns_below(folder)
        for campaign in campaigns:
            name = campaign.resolve().name
            if name in found:
                got = f"{found[name]} and {campaign}"
                raise InputError(str(folder), expected="campaigns with names of their own", got=got)
            found[name] = campaign
    return found


def _campaigns_below(folder: Path) -> list[Path]:
    """Return the folders with a campaign.toml directly below ``folder``."""
    if not folder.is_dir():
        raise InputError(str(folder), expected="a campaign or a folder of campaigns", got="no such folder")
    campaigns = sorted(path.parent for path in folder.glob(f"*/{DESCRIPTION}"))
    if not campaigns:
        todo = "haptid init makes a campaign from a folder of tables"
        raise InputError(str(folder), expected="a campaign or a folder of campaigns", got="none", todo=todo)
    return campaigns


def digest_of(campaign: Path, options: Mapping[str, object], code: bytes) -> str:
    """Compute a digest of a campaign's files, of the options, and of the code.

    Parameters
    ----------
    campaign
        Folder of the campaign.
    options
        Options that decide the result.
    code
        Digest of the code that identifies.

    Returns
    -------
    str
        Sixteen hexadecimal digits of the SHA-256.
    """
    digest = hashlib.sha256(code + repr(sorted(options.items())).encode())
    for path in sorted(path for path in campaign.rglob("*") if path.is_file()):
        digest.update(str(path.relative_to(campaign)).encode() + path.read_bytes())
    return digest.hexdigest()[:16]
