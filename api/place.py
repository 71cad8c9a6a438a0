"""Folders of results: `Place`, the user's own folder, or a temporary one that lives as long as its results."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from haptid.support.errors import InputError
from haptid.support.files.files import check_writable
from haptid.support.files.folder_lock import NAME as LOCK
from haptid.support.files.folder_lock import lock_folder


@dataclass(frozen=True, eq=False)
class Place:
    """Folder with the files of a result, the same that the commands write below ``--out``.

    Parameters
    ----------
    path
        The folder.
    temporary
        Whether it is removed with the last result that refers to it; then no pages and pictures are written there.
    """

    path: Path
    temporary: bool = False

    @property
    def lasting(self) -> Path | None:
        """The folder where it is the user's; None for a temporary one."""
        return None if self.temporary else self.path

    @classmethod
    def of(cls, folder: Path | str | None) -> Place:
        """Return the user's folder, or a new temporary one that is removed with the last result that refers to it.

        Parameters
        ----------
        folder
            Folder that may not exist yet; None for a temporary one.

        Returns
        -------
        Place
            Absolute, and temporary where no folder was given.

        Raises
        ------
        InputError, WritingError
            Where the folder cannot be written.
        """
        if folder is not None:
            check_writable(Path(folder))
            return cls.existing(folder)
        place = cls(Path(tempfile.mkdtemp(prefix="haptid-")), temporary=True)
        weakref.finalize(place, shutil.rmtree, place.path, ignore_errors=True)
        return place

    @classmethod
    def existing(cls, folder: Path | str) -> Place:
        """Return the user's folder, which need not be writable; it stays the same where the program goes elsewhere.

        Parameters
        ----------
        folder
            Folder of the user.

        Returns
        -------
        Place
            With an absolute path.
        """
        return cls(Path(folder).absolute())

    def copy_to(self, folder: Path | str) -> Place:
        """Copy all files into a folder, over those of the same names.

        Parameters
        ----------
        folder
            Folder that may not exist yet.

        Returns
        -------
        Place
            That folder.

        Raises
        ------
        InputError, WritingError
            Where the folder cannot be written.
        """
        place = Place.of(folder)
        if place.path.resolve() != self.path.resolve():
            shutil.copytree(self.path, place.path, dirs_exist_ok=True, ignore=shutil.ignore_patterns(LOCK))
        return place


def word_origin(call: str, command: str) -> str:
    """Tell how the files of a result come about, to one who reads a folder that has none.

    Parameters
    ----------
    call
        Method of `haptid.Campaign`.
    command
        Command of ``haptid``.

    Returns
    -------
    str
        What to do, for an error.
    """
    return f"name the folder that Campaign.{call}(out=...) or haptid {command} --out wrote"


def require_result(source: Path, wanted: str, made: str) -> None:
    """Refuse a folder that holds no such result.

    Parameters
    ----------
    source
        File of the result.
    wanted
        Kind of file, in words.
    made
        How the file comes about, as `word_origin` says.

    Raises
    ------
    InputError
        Where there is no such file.
    """
    if not source.exists():
        raise InputError(str(source), expected=wanted, got="no such file", todo=made)


@contextmanager
def lock_place(folder: Path | str | None) -> Iterator[None]:
    """Lock the user's folder against other commands and programs within the block.

    Parameters
    ----------
    folder
        The folder; None for none, as nobody else knows a temporary one.

    Raises
    ------
    InputError
        Where another one is writing there.
    """
    if folder is None:
        yield
        return
    check_writable(Path(folder))
    with lock_folder(Path(folder)):
        yield
