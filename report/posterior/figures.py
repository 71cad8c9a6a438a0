"""Figures of a posterior: draws and bands in; corner plot, widths, rank plots, predictive bands and cycles out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.measurement.values.run import Array
from haptid.report.common.cycles import tell_cycles
from haptid.report.common.marks import tell
from haptid.report.common.numbers import HALF_WIDTH_95
from haptid.report.common.style import ACCENT, BAND, MEASURED, RESIDUAL, SIMULATED, figure, style
from haptid.support.linear_algebra import largest_magnitude
from haptid.support.numbers import choose_unit
from haptid.uq.prediction.predict import Bands


def corner(values: Array, names: Sequence[str], logarithmic: Sequence[bool]) -> Figure:
    """Draw the scatter of every pair of parameters and the histogram of each.

    Parameters
    ----------
    values
        Draws of the untransformed values, shape (n_draws, n).
    names
        Ids of the parameters.
    logarithmic
        Whether each parameter is sampled in its logarithm: such parameters, those of the noise model excepted, are
        shown relative to their median [%].

    Returns
    -------
    Figure
        Square of panels, histograms on the diagonal.
    """
    shown, labels = _relative(values, names, logarithmic)
    n = len(names)
    with style():
        made = figure(1.05 * n + 1.0, 1.05 * n + 0.6)
        axes = made.subplots(n, n, squeeze=False)
        limits = np.quantile(shown, [0.001, 0.999], axis=0).T
        limits[:, 1] += 1e-12  # a parameter that never moved still has an axis of some width
        for i in range(n):
            for j in range(n):
                _corner_cell(axes[i][j], shown, i, j, limits)
        for i in range(n):
            axes[-1][i].set_xlabel(labels[i], fontsize=6, rotation=20)
            if i:
                axes[i][0].set_ylabel(labels[i], fontsize=6, rotation=60, labelpad=12)
    return made


def _relative(values: Array, names: Sequence[str], logarithmic: Sequence[bool]) -> tuple[Array, list[str]]:
    shown, labels = values.copy(), list(names)
    for i, flag in enumerate(logarithmic):
        if flag and not names[i].endswith(("_scatter", "model_error", "error_time")):
            shown[:, i] = 100 * (values[:, i] / np.median(values[:, i]) - 1)
            labels[i] = f"{names[i]} [%]"
    return shown, labels


def _corner_cell(ax: Axes, shown: Array, i: int, j: int, limits: Array) -> None:
    ax.tick_params(labelsize=4, length=2, labelleft=False, labelbottom=False)
    ax.grid(visible=False)
    if j > i:
        ax.set_visible(False)
        return
    if i == j:
        ax.hist(shown[:, i], bins=40, range=tuple(limits[i]), color=SIMULATED, histtype="stepfilled")
        ax.set_yticks([])
    else:
        ax.plot(shown[:, j], shown[:, i], ",", color=SIMULATED, alpha=0.6, rasterized=True)
        ax.set_ylim(*limits[i])
    ax.set_xlim(*limits[j])


def widths(names: Sequence[str], posterior: Array, prior: Array) -> Figure:
    """Draw the half-width of each parameter's 95 % interval within that of its prior.

    Parameters
    ----------
    names
        Ids of the parameters.
    posterior, prior
        Half-widths in percent of the value, shape (n,) each; drawn up to 1000 %.

    Returns
    -------
    Figure
        A bar a parameter, the best known at the bottom, on a logarithmic axis up to 1000 %.
    """
    with style():
        made = figure(9.0, 0.24 * len(names) + 0.9)
        draw_widths(made.subplots(), names, posterior, prior)
    return made


def draw_widths(axis: Axes, names: Sequence[str], posterior: Array, prior: Array) -> None:
    """Draw the half-width of each parameter's 95 % interval within that of its prior.

    Parameters
    ----------
    axis
        Axes to draw on.
    names, posterior, prior
        As `widths` takes them.
    """
    order = np.argsort(posterior)  # best known at the bottom
    low = 10 ** np.floor(np.log10(max(float(np.min(posterior)), 1e-6)))
    for row, i in enumerate(order):
        axis.barh(row, min(prior[i], 1000.0) - low, left=low, color=BAND, height=0.75)
        axis.barh(row, min(posterior[i], 1000.0) - low, left=low, color=SIMULATED, height=0.75)
        axis.text(1050.0, row, f"± {posterior[i]:.2g} %", va="center", fontsize=7)
        told = f"{names[i]}: ± {posterior[i]:.3g} % with the data, ± {prior[i]:.3g} % by the prior alone"
        tell(axis, min(posterior[i], 1000.0), row, told, "row")
    axis.set_xscale("log")
    axis.set_xlim(low, 1000.0)
    axis.set_yticks(range(len(names)), [names[i] for i in order], fontsize=7)
    axis.set_xlabel("95 % half-width in percent of the value (dark: with the data, pale: prior alone)")
    axis.grid(visible=False, axis="y")


def ranks(chains: Array, names: Sequence[str], bins: int = 20) -> Figure:
    """Draw rank plots (Vehtari et al. 2021, section 5): each ensemble's share of every range of ranks.

    Level bars mean that the ensembles agree.

    Parameters
    ----------
    chains
        Draws, shape (n_chains, n_draws, n).
    names
        Ids of the coordinates.
    bins
        Number of ranges of ranks.

    Returns
    -------
    Figure
        A panel a coordinate; 1 is the share that agreeing ensembles have.

    References
    ----------
    Vehtari et al., Rank-normalization, folding, and localization: an improved R̂, 2021, section 5.
    """
    count, draws, n = chains.shape
    columns = min(n, 5)
    rows = -(-n // columns)
    with style():
        made = figure(1.9 * columns, 1.3 * rows)
        axes = made.subplots(rows, columns, squeeze=False).ravel()
        for i, ax in enumerate(axes):
            ax.set_visible(i < n)
            if i >= n:
                continue
            order = np.argsort(np.argsort(chains[..., i].ravel(), kind="stable"), kind="stable").reshape(count, draws)
            for c in range(count):
                share, edges = np.histogram(order[c], bins=bins, range=(0, count * draws))
                ax.stairs(share * bins / draws, edges, lw=0.9)
            ax.axhline(1.0, color=MEASURED, lw=0.6, ls=":")
            ax.set_title(names[i], fontsize=7)
            ax.set_ylim(0, 2.5)
            ax.set_xticks([])
            ax.tick_params(labelsize=5)
    return made


def bands(parts: Sequence[Bands]) -> Figure:
    """Draw what was measured with its predictive band, and the residual of the predictive median with all bands.

    Parameters
    ----------
    parts
        Bands of every run; each run has a row of the figure.

    Returns
    -------
    Figure
        Readings with the 95 % band on the left, residuals with all bands on the right.
    """
    with style():
        made = figure(9.0, 1.9 * len(parts))
        axes = made.subplots(len(parts), 2, squeeze=False)
        for row, part in zip(axes, parts, strict=True):
            draw_band(row[0], part)
            draw_residual_bands(row[1], part)
        axes[0][0].legend(fontsize=6, loc="upper right")
        for ax in axes[-1]:
            ax.set_xlabel("time [s]")
    return made


def draw_band(axis: Axes, part: Bands) -> None:
    """Draw the measured position of a run over its predictive 95 % band.

    Parameters
    ----------
    axis
        Axes to draw on.
    part
        Bands of the run.
    """
    run = part.run
    axis.fill_between(run.t, part.lower[-1], part.upper[-1], color=BAND, label="95 % band")
    axis.plot(run.t, run.y[:, 0], color=MEASURED, lw=0.8, label="measured")
    axis.set_ylabel(part.unit)
    axis.set_title(f"{run.file} ({run.use})", fontsize=7, loc="left")


def draw_residual_bands(axis: Axes, part: Bands) -> None:
    """Draw measured position minus predictive median of a run over the bands of 50, 80 and 95 %.

    Parameters
    ----------
    axis
        Axes to draw on.
    part
        Bands of the run.
    """
    run, missed = part.run, part.run.y[:, 0] - part.median
    unit, factor = choose_unit(largest_magnitude(missed), part.unit)
    for k in (2, 1, 0):
        low, high = factor * (part.lower[k] - part.median), factor * (part.upper[k] - part.median)
        axis.fill_between(run.t, low, high, color=SIMULATED, alpha=(0.45, 0.3, 0.18)[k], lw=0)
    axis.plot(run.t, factor * missed, color=RESIDUAL, lw=0.4, alpha=0.8)
    axis.set_ylabel(unit)
    shares = ", ".join(f"{100 * c:.1f}" for c in part.covered)
    axis.set_title(f"residual; bands of 50, 80, 95 % hold {shares} %", fontsize=7, loc="left")


def draw_marginal(axis: Axes, posterior: Array, prior: Array, label: str) -> None:
    """Draw the histogram of a parameter's draws over that of its prior, both as densities.

    Parameters
    ----------
    axis
        Axes to draw on.
    posterior, prior
        Draws of the parameter in its unit, shape (n,) each. Only the part of the prior near the posterior is shown.
    label
        Name and unit of the parameter.
    """
    low, high = np.quantile(posterior, [0.001, 0.999])
    reach = max(high - low, 1e-12)  # a parameter that never moved still has an axis of some width
    edges = np.linspace(low - reach / 2, high + reach / 2, 81)
    share = np.histogram(prior, bins=edges)[0] / (prior.size * np.diff(edges))
    axis.stairs(share, edges, color=ACCENT, label="prior")
    axis.hist(posterior, bins=edges.tolist(), density=True, color=SIMULATED, histtype="stepfilled", label="posterior")
    axis.set_xlabel(label)
    axis.set_yticks([])
    axis.legend(fontsize=7)


def cycles(parts: Sequence[Bands], scatter: Array) -> Figure | None:
    """Draw the amplitude factor of every cycle with its 95 % interval beside the posterior of the scatter.

    Parameters
    ----------
    parts
        Bands of every run.
    scatter
        Draws of the scatter s [1], shape (n_draws,).

    Returns
    -------
    Figure or None
        None where the noise model has no scatter.
    """
    parts = [part for part in parts if len(part.cycle_factors)]
    if not parts:
        return None
    with style():
        made = figure(9.0, 2.6)
        left, right = made.subplots(1, 2, width_ratios=(3, 1))
        place = 0
        for part in parts:
            mean, std = part.cycle_factors.T
            at = place + np.arange(len(mean), dtype=float)
            colour = SIMULATED if part.run.use == "fit" else ACCENT
            left.errorbar(at, 100 * (mean - 1), 100 * HALF_WIDTH_95 * std, fmt="o", ms=3, lw=1, color=colour)
            tell_cycles(left, at, f"{part.run.file} ({part.run.use})", mean - 1, std)
            left.text(place, 1.0, part.run.file, fontsize=5, rotation=20, transform=left.get_xaxis_transform())
            place += len(mean) + 1
        left.axhline(0, color=MEASURED, lw=0.6)
        left.set_xlabel("cycle, run after run")
        left.set_ylabel("amplitude − 1 [%]")
        right.hist(100 * scatter, bins=40, color=SIMULATED)
        right.set_xlabel("scatter s [%]")
        right.set_yticks([])
    return made
