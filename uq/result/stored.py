"""The posterior of one joint in its files: ``joint<j>.nc`` and its entry of ``posterior.json`` in, arrays out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError
from haptid.support.files.files import is_file
from haptid.uq.prediction.predict import Bands
from haptid.uq.result.arviz_door import read_netcdf

WANTED = "chains that haptid posterior wrote"
DAMAGE = (OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, RuntimeError, IndexError)
"""Errors of the libraries behind ArviZ for files that are damaged or hold something else."""


def read_chains(path: Path) -> Any:
    """Read the chains of a joint.

    Parameters
    ----------
    path
        File that `uq.result.record.save_chains` wrote.

    Returns
    -------
    arviz.InferenceData
        It does not need the file any more.

    Raises
    ------
    InputError
        Where there is no such file, or it is damaged.
    """
    if not is_file(path):
        raise InputError(str(path), expected=WANTED, got="no such file")
    try:
        return read_netcdf(path)
    except DAMAGE as error:
        got = f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else 'damaged'}"
        raise InputError(str(path), expected=WANTED, got=got) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredPosterior:
    """Draws, prior and predictive bands of a joint.

    Parameters
    ----------
    entry
        Entry of the joint in ``posterior.json``.
    posterior, prior
        Draws by id, those of the noise model included, in the parameters' units, shape (n_draws,) each.
    bands
        Predictive bands of the runs.
    """

    entry: Mapping[str, Any]
    posterior: Mapping[str, Array]
    prior: Mapping[str, Array]
    bands: tuple[Bands, ...]

    @classmethod
    def read(cls, path: Path, entry: Mapping[str, Any]) -> StoredPosterior:
        """Read the posterior of a joint.

        Parameters
        ----------
        path
            File with its chains.
        entry
            Entry of the joint in ``posterior.json``.

        Returns
        -------
        StoredPosterior

        Raises
        ------
        InputError
            Where the file is damaged, or another version of haptid wrote it.
        """
        data = read_chains(path)
        try:
            bands = tuple(_bands(data, entry, k) for k in range(len(entry["runs"])))
            posterior, prior = _draws(data.posterior), _draws(data.prior)
        except DAMAGE as error:
            got = f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else 'damaged'}"
            raise InputError(str(path), expected=WANTED, got=got, todo="sample again with this version") from None
        return cls(entry=entry, posterior=posterior, prior=prior, bands=bands)

    def unit(self, id: str) -> str:
        """Return the unit of a parameter.

        Parameters
        ----------
        id
            Id of the parameter.

        Returns
        -------
        str
        """
        return str(self.entry["parameters"][id]["unit"])

    def relative_widths(self) -> tuple[list[str], Array, Array]:
        """Return the half-width of each parameter's 95 % interval and of its prior's.

        Returns
        -------
        names, posterior, prior
            Ids of the equations' parameters, and half-widths in percent of the absolute median, shape (n,) each.
        """
        ids = list(self.entry["correlation"]["ids"])
        stated = [self.entry["parameters"][id] for id in ids]
        scale = np.array([max(abs(one["median"]), 1e-300) for one in stated])
        # Ends of the posterior are those of all chains, of which the file holds a part.
        ends = np.array([one["intervals"]["0.95"] for one in stated]).reshape(-1, 2)
        prior = np.array([np.quantile(self.prior[id], [0.025, 0.975]) for id in ids]).reshape(-1, 2)
        half = 100.0 / 2.0 / scale
        return ids, half * np.diff(ends)[:, 0], half * np.diff(prior)[:, 0]


def _draws(group: Any) -> dict[str, Array]:
    return {str(name): np.asarray(values, dtype=np.float64).ravel() for name, values in group.data_vars.items()}


def _bands(data: Any, entry: Mapping[str, Any], k: int) -> Bands:
    stated, known = entry["runs"][k], data.constant_data
    t = np.asarray(known[f"time_{k}"], dtype=np.float64)
    lower, upper = np.split(np.asarray(known[f"band_{k}"], dtype=np.float64), 2)
    measured = np.asarray(data.observed_data[f"{entry['residual']}_{k}"], dtype=np.float64)
    run = Run(
        file=stated["file"],
        free_joints=(entry["joint"],),
        t=t,
        u=np.full((t.size, 1), np.nan),  # no figure shows it
        y=measured[:, None],
        noise=np.full(1, np.nan),
        resolution=np.zeros(1),
        posture=np.zeros(0),
        use=stated["use"],
    )
    return Bands(
        run=run,
        median=np.asarray(known[f"median_{k}"], dtype=np.float64),
        lower=lower,
        upper=upper,
        covered=np.array([np.nan if share is None else share for share in stated["covered"].values()]),
        cycle_factors=np.array(stated.get("cycle_factors", ()), dtype=np.float64).reshape(-1, 2),
        unit=str(data.attrs["unit"]),
    )
