"""Tables on the pages about other simulators, from the stored results of this folder's commands."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.parts.tables import table, with_parts
from haptid.support.files.files import write_text
from studies.ledger.version import tell_version

DOCS = Path(__file__).parents[2] / "docs"
FMU = DOCS / "theory" / "fmu.md"
FMUS, BODIES = DOCS / "how-to" / "other_simulators.md", DOCS / "how-to" / "rigid_body_simulators.md"
FOREIGN = DOCS / "how-to" / "foreign_fmu.md"
SCRIPT = "benchmarks/simulators/page.py"
PACKAGINGS = {"python": "Python", "native": "native", "native3": "native, FMI 3.0"}


def measured(stored: Mapping[str, Any]) -> str:
    """Return with which command, when, in which version and where results were made."""
    return f"`{stored['command'].strip()}`, {stored['date']}, {tell_version(stored)}, {stored['machine']}."


def _outcome(rows: Sequence[Mapping[str, Any]], aim: float) -> str:
    """Return what a client made of all FMUs of one packaging."""
    failed = [row for row in rows if "largest_difference" not in row]
    if failed:
        return failed[0].get("not_here") or f"{len(failed)} of {len(rows)} failed: {failed[0]['failed']}"
    columns = sum(row["columns"] for row in rows)
    worst = max(row["largest_difference"] for row in rows)
    size = f"≤ {worst:.1e}" if worst else "the same bits"
    text = f"{len(rows)} FMUs, {columns} columns: {size}" + ("" if worst <= aim else f", above {aim:g}")
    if "to_reference_run" not in rows[0]:
        return text
    step_error = max(row["to_reference_run"] for row in rows)
    return f"{text} to the FMU in steps of 3.9 µs (≤ {step_error:.1e} to the reference run)"


def clients_text(stored: Mapping[str, Any]) -> str:
    """Return the table of clients."""
    lines = []
    for word, client in stored["clients"].items():
        for kind, words in PACKAGINGS.items():
            rows = [row for row in stored["rows"] if (row["client"], row["kind"]) == (word, kind)]
            if rows:
                lines.append(
                    (client["name"], client["version"], words, _outcome(rows, client["aim"]), f"`{client['how']}`")
                )
    header = ("client", "version", "packaging", "largest difference to the reference run, all outputs", "how")
    absent = [f"- {name}: {reason}" for name, reason in stored["absent"].items()]
    return "\n".join((
        "Ran: FMUs of each locked joint, of joints 0 and 1, and of the whole device at its identified values. Every "
        "output counts at every row, in its own unit (rad, rad/s, N m, m, 1). Model exchange solves the equations to a "
        "tolerance, the others step the FMU, whose inner steps of 0.5 ms have an error of their own: so CVode is "
        "compared with the FMU in shorter steps as well. One client on one FMU: "
        "`python -m benchmarks.simulators.drivers ecos NAME.fmu`.",
        "",
        measured(stored),
        "",
        table(header, lines),
        "fmuloader is installed for this run alone: its package states no licence, and haptid declares none without.",
        "",
        f"`fmpy validate` finds {stored['problems']} problems in the {stored['validated']} FMUs.",
        "",
        "Not run, and why:",
        "",
        *absent,
    ))  # fmt: skip


def terms_text(stored: Mapping[str, Any]) -> str:
    """Return the table of mass matrices and biases."""
    rows = [(row["file"], row["reader"], f"{row['mass_matrix']:.1e}", f"{row['bias']:.1e}") for row in stored["terms"]]
    header = ("file", "reader", "mass matrix", "Coriolis, centrifugal and gravity torques")
    versions = f"MuJoCo {stored['mujoco']}, Pinocchio {stored['pinocchio']}"
    return "\n".join((
        f"Largest difference to haptid's own over {stored['states']} random states, relative to the largest entry; "
        f"passive links are taken along as their joint moves them. {versions}. {measured(stored)}",
        "",
        table(header, rows),
    ))  # fmt: skip


def motions_text(stored: Mapping[str, Any]) -> str:
    """Return the table of motions, the worse run of each way."""
    ways = dict.fromkeys((row["friction"], row["integrator"], row["step_s"]) for row in stored["motions"])
    lines = []
    for friction, integrator, step in ways:
        rows = [
            row for row in stored["motions"]
            if (row["friction"], row["integrator"], row["step_s"]) == (friction, integrator, step)
        ]  # fmt: skip
        lines.append((
            friction,
            integrator,
            f"{1e3 * step:g} ms",
            f"{max(max(row['rms_rad']) for row in rows):.2g}",
            f"{max(max(row['rms_over_noise']) for row in rows):.2g}",
            f"{max(row['largest_rad'] for row in rows):.2g}",
            f"{1e3 * max(row['largest_handle_m'] for row in rows):.2g}",
            f"{max(row['duration_s'] / row['wall_s'] for row in rows):.0f}",
        ))  # fmt: skip
    header = (
        "friction of the MJCF", "integrator", "step", "RMS, worst joint [rad]", "over the noise", "largest [rad]",
        "handle, largest [mm]", "times real time",
    )  # fmt: skip
    runs = len({row["run"] for row in stored["motions"]})
    duration = stored["motions"][0]["duration_s"]
    slip = max(row["slip_rad"] for row in stored["motions"])
    return "\n".join((
        f"Motion in MuJoCo {stored['mujoco']} less motion of the FMU in FMPy {stored['fmpy']}, at the same values, "
        f"under the recorded torques of {runs} runs with all joints free, {duration:g} s each, from the measured start "
        f"and without feedback; the noise of the sensor is {stored['noise_rad']:g} rad. Given is the worse run. "
        f"Passive links are at most {slip:.1g} rad from where their joint puts them. {measured(stored)}",
        "",
        table(header, lines),
    ))  # fmt: skip


def foreign_text(stored: Mapping[str, Any]) -> str:
    """Return the table of foreign FMUs that were calibrated."""
    lines = []
    for row in stored["rows"]:
        first = (row["title"], row["generator"])
        if "failed" in row:
            lines.append((*first, f"does not load here: {row['failed']}", "", "", "", ""))
            continue
        found = [
            f"{name} = {one['value']:.5g} ± {one['std']:.1g} ({one['truth']:g})"
            for name, one in row["parameters"].items()
        ]
        theirs = row.get("modestpy_s")
        lines.append((
            *first,
            ", ".join(found),
            f"{row['validate_over_noise']:.2f}",
            f"{row['wall_s']:.0f}",
            f"{1e3 * row['simulation_s']:.2g}",
            f"{1e3 * theirs:.2g}" if theirs else "",
        ))  # fmt: skip
    header = (
        "FMU", "made by", "found ± std (hidden)", "RMS over the noise, unseen run", "whole command [s]",
        "one simulation [ms]", "the same by ModestPy [ms]",
    )  # fmt: skip
    done = sum("failed" not in row for row in stored["rows"])
    modestpy = stored["modestpy"].replace("==", " ")
    return "\n".join((
        f"SYNTHETIC: {done} of {len(stored['rows'])} FMUs that are not ours, simulated by FMPy at hidden values, with "
        f"white noise. {modestpy} takes FMI 2.0 with inputs alone. {measured(stored)}",
        "",
        table(header, lines),
    ))  # fmt: skip


def platforms_text(stored: Mapping[str, Any]) -> str:
    """Return which platform's binaries gave which bits, and what two builds have in common."""
    ran = [row for row in stored["rows"] if "sha256" in row]
    first = {(row["fmu"], row["kind"]): row["sha256"] for row in reversed(ran)}
    lines = []
    for place in dict.fromkeys(row["platform"] for row in stored["rows"]):
        rows = [row for row in stored["rows"] if row["platform"] == place]
        size = f"{rows[0]['joint_bytes'] / 1e3:.0f}"
        if "missing" in rows[0]:
            lines.append((place, f"built, not run: {rows[0]['missing']}", "", "", size))
            continue
        same = sum(row["sha256"] == first[row["fmu"], row["kind"]] for row in rows)
        worst = max(row["largest_difference"] for row in rows)
        version = "" if rows[0]["by"] == "this machine" else f": {rows[0]['version']}"
        lines.append(
            (place, f"{rows[0]['by']}{version}", f"{same} of {len(rows)}", f"{worst:.1e}" if worst else "0", size)
        )
    header = (
        "platform", "run by", "FMUs that gave the bits of the first", "largest difference to the reference run",
        "binary of joint 4 [kB]",
    )  # fmt: skip
    archives = stored["archives"]
    paths = len(archives["places"]) or "none"
    names = ", ".join(dict.fromkeys(row["fmu"] for row in ran))
    return "\n".join((
        f"Binaries of native FMUs ({names}; FMI 2.0 and 3.0) on their reference runs, every output at every row, "
        f"stepped by a host in C that is compiled for the same platform. {measured(stored)}",
        "",
        table(header, lines),
        f"Built twice, in different caches and temporary folders: {archives['same_bytes']} of "
        f"{archives['built_twice']} archives (Python, native, FMI 3.0; all platforms) have the same bytes. Paths of "
        f"the building machine inside: {paths}.",
    ))  # fmt: skip


def speed_text(stored: Mapping[str, Any]) -> str:
    """Return what a step costs beside a loop that is written by hand."""
    rows = [(name, f"{value:.0f}") for name, value in stored["ns_per_step"].items()]
    return "\n".join((
        f"One step of {1e3 * stored['step_s']:g} ms of joint 4: processor time, {stored['repeats']} interleaved "
        f"repeats. The loop by hand (`benchmarks/models/fmu_hand_written.c`) takes "
        f"{stored['speed_over_by_hand']:.2f} times the native FMU's time by the shortest repeats, "
        f"{stored['speed_over_by_hand_median']:.2f} times in the median "
        f"of the pairs. It uses the same method, but neither checks nor sub-steps. {measured(stored)}",
        "",
        table(("what", "ns a step"), rows),
    ))  # fmt: skip


def parts_by_page() -> dict[Path, dict[str, str]]:
    """Return the generated parts of each page from what is stored."""
    names = ("clients", "multibody", "foreign_fmus", "platforms", "fmu_speed")
    clients, bodies, foreign, platforms, speed = (
        json.loads((DOCS / "results" / f"{n}.json").read_text(encoding="utf-8")) for n in names
    )
    return {
        FMUS: {"clients": clients_text(clients)},
        BODIES: {"terms": terms_text(bodies), "motions": motions_text(bodies)},
        FOREIGN: {"foreign FMUs": foreign_text(foreign)},
        FMU: {"platforms": platforms_text(platforms), "speed": speed_text(speed)},
    }


def write() -> None:
    """Write the generated parts of all pages."""
    for path, texts in parts_by_page().items():
        write_text(path, with_parts(path.read_text(encoding="utf-8"), texts, SCRIPT))
