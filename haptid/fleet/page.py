"""The page of a fleet: devices and `Comparison`s in, `Page` out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from haptid.fleet.comparison import FEWEST_DEVICES, Comparison, Member
from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import with_error
from haptid.report.common.page import Page, Picture, Section, Table, word_cell
from haptid.report.common.style import ACCENT, RESIDUAL, SIMULATED, figure, style

METHOD = (
    "A robust z is (value − median of the devices) / √(spread² + std²); the spread is 1.4826 times the median absolute "
    "deviation. A device is told as deviating where its |z| is beyond the limit: that of as many equal devices exceeds "
    "it anywhere in 5 % of fleets. Only parameters with the status identified are judged. A deviation says that "
    "this device or its tests differ from the others, not which of the two, nor that it is faulty."
)


def fleet_page(devices: Sequence[Mapping[str, Any]], comparisons: Sequence[Comparison], lead: str) -> Page:
    """Render the page.

    Parameters
    ----------
    devices
        Name, outcome, worst residual and error of each device.
    comparisons
        Every parameter over the devices.
    lead
        Which devices deviate, in a sentence.

    Returns
    -------
    Page
        With the synthetic label where any campaign is synthetic.
    """
    judged = [one for one in comparisons if one.limit is not None]
    pictures = [z_picture(judged)] if judged else []
    synthetic = [device["measured"] is False for device in devices if device["measured"] is not None]
    return Page(
        title="Devices of a fleet, compared",
        lead=lead,
        sections=[
            Section(title="Devices", anchor="devices", tables=[_devices(devices)]),
            Section(title="Who deviates", anchor="deviating", paragraphs=[METHOD], pictures=pictures,
                    tables=[_deviating(judged)]),
            Section(title="All parameters", anchor="parameters",
                    tables=[_parameters(comparisons, [device["name"] for device in devices])]),
        ],
        synthetic=any(synthetic) if synthetic else None,
    )  # fmt: skip


def _devices(devices: Sequence[Mapping[str, Any]]) -> Table:
    rows = [
        (
            d["name"],
            word_cell("fit", d["outcome"]),
            "–" if d["worst_over_noise"] is None else f"{d['worst_over_noise']:.3g}",
            d["error"],
        )
        for d in devices
    ]
    return Table(header=("device", "outcome", "worst unseen run, × noise", "what failed"), rows=rows)


def _deviating(judged: Sequence[Comparison]) -> Table:
    rows = [
        (member.device, one.configuration, one.parameter, with_error(member.value, member.std),
         f"{one.median:.4g} ± {one.spread:.2g}", one.unit, f"{member.z:+.1f}", f"{one.limit:.1f}")
        for one in judged for member in one.members if member.deviates
    ]  # fmt: skip
    header = ("device", "tested", "parameter", "value ± std", "median ± spread of the devices", "unit", "z", "limit")
    return Table(header=header, rows=rows)


def _parameters(comparisons: Sequence[Comparison], devices: Sequence[str]) -> Table:
    rows = []
    for one in comparisons:
        by_device = {member.device: member for member in one.members}
        cells = [_cell(by_device.get(device)) for device in devices]
        middle = "–" if one.median is None else f"{one.median:.4g} ± {one.spread:.2g}"
        rows.append((one.configuration, one.parameter, one.unit, middle, *cells))
    few = f"Below {FEWEST_DEVICES} devices in which a parameter is identified, it has no median and nobody is judged."
    return Table(header=("tested", "parameter", "unit", "median ± spread", *devices), rows=rows, caption=few)


def _cell(member: Member | None) -> str:
    if member is None:
        return "–"
    number = with_error(member.value, member.std) if member.std > 0 else f"{member.value:.4g}"
    status = "" if member.status == "identified" else f" ({member.status})"
    return number + status + (" deviates" if member.deviates else "")


def z_picture(judged: Sequence[Comparison]) -> Picture:
    """Draw the robust z of every device, one line a parameter.

    Parameters
    ----------
    judged
        Comparisons with a limit.

    Returns
    -------
    Picture
        Devices that deviate are named; the line of a parameter spans ± its limit.
    """
    with style():
        made = figure(8.0, 1.2 + 0.22 * len(judged))
        axis = made.subplots()
        for row, one in enumerate(judged):
            axis.plot([-(one.limit or 0), one.limit or 0], [row, row], color=ACCENT, lw=0.8, marker="|")
            for member in one.members:
                if member.z is not None:
                    axis.plot(member.z, row, "o", ms=4, color=RESIDUAL if member.deviates else SIMULATED)
                if member.deviates:
                    axis.annotate(f" {member.device}", (member.z or 0.0, row), fontsize=7, va="center")
        axis.set_yticks(range(len(judged)), [f"{one.configuration}: {one.parameter}" for one in judged], fontsize=7)
        axis.set_xscale("symlog", linthresh=10)  # a device that is another machine altogether stays on the picture
        axis.xaxis.set_major_formatter("{x:g}")
        axis.invert_yaxis()
        axis.set_xlabel("robust z of each device [1]")
    caption = "One dot a device; the line spans what equal devices would reach."
    return picture_of(made, caption=caption, alt="robust z of every device by parameter")
