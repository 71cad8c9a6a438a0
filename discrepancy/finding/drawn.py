"""What the figures of a finding are drawn from: any finding in, `Drawn` out, an archive of arrays beside its JSON."""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from haptid.discrepancy.detect.localise import Map
from haptid.discrepancy.finding.finding import Curve, Finding
from haptid.discrepancy.finding.full_model import WholeFinding
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError
from haptid.support.files.files import read_content, write_bytes

SUFFIX = ".npz"
"""Ending of the archive, which has the name of the finding's JSON."""
INDEX = "index"
"""Array of the archive that holds what is no number, as JSON."""
DAMAGE = (
    ValueError,
    EOFError,
    KeyError,
    TypeError,
    IndexError,
    AttributeError,
    OSError,
    zipfile.BadZipFile,
    zlib.error,
)
"""Errors of NumPy, of its archive and of the index in files that another program or a fault changed."""
WANTED = "the curves of a finding"


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueLeft:
    """Residual torque on the stretches that no fit saw.

    Parameters
    ----------
    stretches
        Position [rad] ([m]) and the torque left before and after the search [N m] ([N]), shape (3, n) a run.
    noise
        RMS of the torque's noise [N m] ([N]).
    largest
        Largest measured torque [N m] ([N]), which chooses the unit; 0 where an earlier version did not store it.
    """

    stretches: tuple[Array, ...]
    noise: float
    largest: float = 0.0

    @classmethod
    def of(cls, finding: TorqueFinding) -> TorqueLeft:
        """Take the residual torque out of a finding.

        Parameters
        ----------
        finding
            Finding of a joint whose torque was scored.

        Returns
        -------
        TorqueLeft
        """
        found, stretches = finding.search, []
        for k, run in enumerate(found.study.runs):
            unseen = found.study.unseen_rows[k]
            columns = (run.u[:, 0], found.base.residual[k], found.final.residual[k])
            stretches.append(np.stack([column[unseen] for column in columns]))
        return cls(stretches=tuple(stretches), noise=finding.gaps["validate"].noise, largest=finding.largest_torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """What the figures of a finding are drawn from.

    Parameters
    ----------
    curves
        Runs with their simulations before and after; none where the torque was searched, or all joints were checked.
    torque_left
        Residual torque; None where the position was searched.
    maps
        Where the nominal model misses.
    prismatic
        Whether each joint slides.
    """

    curves: tuple[Curve, ...] = ()
    torque_left: TorqueLeft | None = None
    maps: tuple[Map, ...] = ()
    prismatic: tuple[bool, ...]

    @classmethod
    def of(cls, finding: Finding | TorqueFinding | WholeFinding) -> Drawn:
        """Take what is drawn out of a finding.

        Parameters
        ----------
        finding
            Finding of any kind.

        Returns
        -------
        Drawn
        """
        if isinstance(finding, WholeFinding):
            return cls(prismatic=tuple(row.prismatic for row in finding.rows))
        if isinstance(finding, TorqueFinding):
            slides = (finding.search.study.prismatic,)
            return cls(torque_left=TorqueLeft.of(finding), maps=finding.maps, prismatic=slides)
        return cls(curves=finding.curves, maps=finding.maps, prismatic=finding.search.study.fitted[0].prismatic)

    def save(self, path: Path) -> Path:
        """Write the archive.

        Parameters
        ----------
        path
            File to write.

        Returns
        -------
        Path
            ``path``.

        Raises
        ------
        InputError, WritingError
            As `write_bytes`.
        """
        arrays: dict[str, Array] = {}
        for k, curve in enumerate(self.curves):
            run = curve.run
            arrays[f"curve{k}"] = np.stack([run.t, run.y[:, 0], curve.before, curve.after])
        for k, part in enumerate(self.maps):
            arrays |= {f"map{k}_{name}": getattr(part, name) for name in ("edges", "excess", "rows")}
        if self.torque_left is not None:
            arrays |= {f"torque{k}": stretch for k, stretch in enumerate(self.torque_left.stretches)}
        content = io.BytesIO()
        np.savez_compressed(content, allow_pickle=False, **{INDEX: np.array(json.dumps(self._index()))}, **arrays)
        return write_bytes(path, content.getvalue())

    def _index(self) -> dict[str, Any]:
        left = self.torque_left
        return {
            "prismatic": [bool(slides) for slides in self.prismatic],
            "curves": [_run_json(curve.run) for curve in self.curves],
            "maps": [{"variable": part.variable, "labels": list(part.labels)} for part in self.maps],
            "torque": None
            if left is None
            else {"stretches": len(left.stretches), "noise": left.noise, "largest": left.largest},
        }

    @classmethod
    def read(cls, path: Path) -> Drawn:
        """Read the archive.

        Parameters
        ----------
        path
            File that `save` wrote.

        Returns
        -------
        Drawn
            Its runs hold what figures need: times, readings, use and the sensor's noise.

        Raises
        ------
        InputError
            Where the file cannot be read, or is no such archive.
        """
        content = io.BytesIO(read_content(path, WANTED))
        try:
            with np.load(content, allow_pickle=False) as arrays:
                return _drawn_from(arrays, json.loads(str(arrays[INDEX])))
        except DAMAGE as error:
            got = f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else 'damaged'}"
            raise InputError(str(path), expected=WANTED, got=got, todo="haptid missing writes it") from None


def _run_json(run: Run) -> dict[str, Any]:
    return {
        "file": run.file,
        "use": run.use,
        "joint": run.free_joints[0],
        "prismatic": bool(run.prismatic[0]),
        "noise": float(run.noise[0]),
        "resolution": float(run.resolution[0]),
    }


def _drawn_from(arrays: Any, index: dict[str, Any]) -> Drawn:
    left = index["torque"]
    maps = [
        Map(
            variable=str(one["variable"]),
            **{name: _numbers(arrays, f"map{k}_{name}", 1) for name in ("edges", "excess", "rows")},
            labels=tuple(map(str, one["labels"])),
        )
        for k, one in enumerate(index["maps"])
    ]
    return Drawn(
        curves=tuple(_curve(_numbers(arrays, f"curve{k}", 2), one) for k, one in enumerate(index["curves"])),
        torque_left=None
        if left is None
        else TorqueLeft(
            stretches=tuple(_numbers(arrays, f"torque{k}", 2) for k in range(left["stretches"])),
            noise=float(left["noise"]),
            largest=float(left.get("largest", 0.0)),
        ),
        maps=tuple(maps),
        prismatic=tuple(bool(slides) for slides in index["prismatic"]),
    )


def _numbers(arrays: Any, name: str, dimensions: int) -> Array:
    array: Array = np.asarray(arrays[name], dtype=np.float64)
    if array.ndim != dimensions:
        msg = f"{name} has {array.ndim} dimensions"
        raise ValueError(msg)
    return array


def _curve(rows: Array, one: dict[str, Any]) -> Curve:
    t, measured, before, after = rows
    run = Run(
        file=str(one["file"]),
        free_joints=(int(one["joint"]),),
        t=t,
        u=np.full((t.size, 1), np.nan),  # no figure shows it
        y=measured[:, None],
        noise=np.array([one["noise"]], dtype=np.float64),
        resolution=np.array([one["resolution"]], dtype=np.float64),
        posture=np.zeros(0),
        use=one["use"],
        prismatic=(bool(one["prismatic"]),),
    )
    return Curve(run=run, before=before, after=after)
