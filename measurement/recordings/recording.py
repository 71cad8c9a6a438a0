"""Find and read the recordings of a folder: each file of another program in, `Recording`s out.

They are read by ``haptid init`` alone: the campaign that it writes has tables. Where a folder holds tables as well, its
recordings are left alone and named, because they mostly are the same measurements once more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from haptid.measurement.format.columns import NUMBERED
from haptid.measurement.recordings import bam_log, lerobot, mat_file, mcap_file, rosbag
from haptid.measurement.recordings.one_run import Recording
from haptid.support.files.files import is_file

READERS: Mapping[str, Callable[[Path], list[Recording]]] = {
    ".mat": mat_file.read_mat,
    ".json": bam_log.read_bam_log,
    ".mcap": mcap_file.read_mcap,
    ".bag": rosbag.read_rosbag,
    ".db3": rosbag.read_rosbag,
}
"""Reader by the end of the file's name."""
BAG_FOLDER = "metadata.yaml"
"""File of a folder into which ROS 2 records; the folder holds the bag's files."""
KINDS = (*READERS, "a LeRobot data set (meta/info.json)")
"""What is read, in words."""


def recordings_in(folder: Path) -> list[Recording]:
    """Read all recordings of a folder.

    Parameters
    ----------
    folder
        Folder with files of other programs or bags of ROS 2, or of a LeRobot data set.

    Returns
    -------
    list of Recording
        In the order of the files' names; empty where there is none.

    Raises
    ------
    InputError
        Where a file is damaged, holds no run, or needs an extra that is not installed.
    """
    if lerobot.is_data_set(folder):
        return lerobot.read_data_set(folder)
    return _numbered_alike([one for path in _files_in(folder) for one in READERS[path.suffix](path)])


def names_of_recordings(folder: Path) -> list[str]:
    """Name the recordings of a folder without reading them.

    Parameters
    ----------
    folder
        Folder with any files.

    Returns
    -------
    list of str
        Paths below the folder; of JSON files those that may be a log of BAM, since others may hold anything.
    """
    files = [path for path in _files_in(folder) if path.suffix != ".json" or bam_log.may_be_log(path)]
    return [str(path.relative_to(folder)) for path in files] + ([str(lerobot.INFO)] * lerobot.is_data_set(folder))


def _files_in(folder: Path) -> list[Path]:
    """Return the files of other programs in a folder, and in the bags of ROS 2 in it."""
    bags = [path.parent for path in folder.glob(f"*/{BAG_FOLDER}")]
    paths = sorted(path for place in (folder, *bags) for path in place.iterdir() if path.suffix in READERS)
    return [path for path in paths if is_file(path)]


def _numbered_alike(recordings: list[Recording]) -> list[Recording]:
    """Give joints of one name one number in all recordings: that of the name's first appearance."""
    names = tuple(dict.fromkeys(name for one in recordings for name in one.table.joints))
    made = []
    for one in recordings:
        numbers = {k: names.index(name) for k, name in enumerate(one.table.joints)}
        columns = {column: _numbered(column, numbers) for column in one.table.columns} if numbers else {}
        table = replace(one.table, frame=one.table.frame.rename(columns=columns), joints=names if numbers else ())
        told = ", ".join(f"{number} {names[number]}" for number in sorted(numbers.values()))
        topic, sign, rest = one.about.partition(";")
        about = f"{topic}, joints {told}{sign}{rest}" if numbers else one.about
        made.append(replace(one, table=table, about=about))
    return made


def _numbered(column: str, numbers: Mapping[int, int]) -> str:
    found = NUMBERED.search(column)
    return column if found is None else NUMBERED.sub(f"_{numbers[int(found[1])]}", column, count=1)
