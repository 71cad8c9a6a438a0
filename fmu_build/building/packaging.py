"""Build an FMU: `Equations` in, `Fmu` file out.

1. Add the observer for an identification FMU, and generate the kernel's C source.
2. Choose the variables, their names and value references (`interface_of`).
3. Write description, sources and binaries of the packaging.
4. Add documentation, accuracy, licences, parameter set, picture and reference run (`extra_files`).
5. Pack the archive, the same bytes for the same content.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from haptid.fmu_build.accuracy.accuracy import FIRST_GUESSES, Accuracy, with_room_for_draws
from haptid.fmu_build.content.extras import extra_files
from haptid.fmu_build.description.interface import Interface, interface_of
from haptid.fmu_build.description.provenance import GUESS, Provenance, provenance_of
from haptid.fmu_build.exchange.archive import pack
from haptid.fmu_build.exchange.possible import with_pairs_in_order
from haptid.fmu_build.native.fmi2 import native_files
from haptid.fmu_build.native.fmi3 import native_files3, rename_picture
from haptid.fmu_build.native.platforms import PLATFORMS, Platform, this_platform
from haptid.fmu_build.python.package import python_files
from haptid.model.equations.equations import Equations
from haptid.model.equations.output_injection import with_observer
from haptid.model.kernel.generate import generate
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from haptid.support.files.files import write_bytes

Kind = Literal["python", "native", "native3"]
"""Packaging: by pythonfmu (FMI 2.0), native in FMI 2.0, native in FMI 3.0."""
_PACKAGINGS = {"python": python_files, "native": native_files, "native3": native_files3}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fmu:
    """Name an FMU on disk with the equations that it holds.

    Parameters
    ----------
    path
        The archive.
    digest
        Sixteen hex digits of its content.
    equations
        Equations of the model, without observer.
    kind
        ``python``, ``native`` or ``native3``.
    step
        Longest internal step [s].
    identification
        Whether it takes the measured position and gives sensitivities.
    """

    path: Path
    digest: str
    equations: Equations
    kind: Kind
    step: float
    identification: bool = False


def interface_for(
    equations: Equations,
    *,
    kind: Kind,
    identification: bool = False,
    values: Mapping[str, float] | None = None,
    step: float = THRESHOLDS.inner_step_s,
    largest_torque: float = 0.0,
) -> Interface:
    """Return the interface of the FMU of some equations.

    Parameters
    ----------
    equations
        Equations without observer.
    kind
        Packaging; the Python packaging does not show state derivatives.
    identification
        Whether to add the observer's inputs and show slopes, sensitivities and the inner step.
    values
        Start values by id of parameter or state, SI units; the first guesses where absent.
    step
        Longest inner step [s].
    largest_torque
        Largest torque that the drives apply [N m], which chooses the display unit; 0 where it is not known.

    Returns
    -------
    Interface
        With the identifier ``<name>_identification`` for an identification FMU, else ``<name>``.

    Raises
    ------
    InputError
        Where a pair of values is out of order, as Fs below Fc: an FMU does not begin with it.
    """
    kernel = generate(with_observer(equations) if identification else equations, step=step)
    return interface_of(
        kernel,
        identifier=f"{equations.name}_identification" if identification else equations.name,
        identification=identification,
        derivatives=kind != "python",
        values=with_pairs_in_order(values or {}, equations, f"start values of {equations.name}"),
        largest_torque=largest_torque,
    )


def build_fmu(  # noqa: PLR0913 # values and all that is said of them
    equations: Equations,
    out: Path,
    *,
    kind: Kind = "python",
    identification: bool = False,
    values: Mapping[str, float] | None = None,
    provenance: Mapping[str, Provenance | str] | None = None,
    accuracy: Accuracy = FIRST_GUESSES,
    platforms: tuple[Platform, ...] | None = None,
    step: float = THRESHOLDS.inner_step_s,
    largest_torque: float = 0.0,
) -> Fmu:
    """Build the FMU of some equations.

    Parameters
    ----------
    equations
        Equations of a joint, a configuration or a whole device, without observer.
    out
        File to write.
    kind
        ``python`` (pythonfmu, the kernel compiled inside), ``native`` (FMI 2.0) or ``native3`` (FMI 3.0, not for
        identification).
    identification
        Take also the measured positions, slopes and the observer gain; give also the sensitivities.
    values
        Start values by id of parameter or state; the first guesses where absent.
    provenance
        Where a parameter's value comes from and its error bar, by id, for the documentation.
    accuracy
        How good the values are; the FMU carries it below ``extra/haptid`` and on its page.
    platforms
        For which to carry binaries; all where None, this machine's alone for identification.
    step
        Longest inner step [s].
    largest_torque
        Largest torque that the drives apply [N m], which chooses the display unit; 0 where it is not known.

    Returns
    -------
    Fmu
        With the digest of the archive.

    Raises
    ------
    InputError
        For an identification FMU in FMI 3.0, where a pair of values is out of order (`with_pairs_in_order`), and where
        the reference run gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    if identification and kind == "native3":
        raise InputError("identification FMU", expected="FMI 2.0, which the fits step", got="FMI 3.0")
    equations = with_room_for_draws(equations, accuracy)
    interface = interface_for(
        equations, kind=kind, identification=identification, values=values, step=step, largest_torque=largest_torque
    )
    if platforms is None:
        platforms = this_platform() if identification else PLATFORMS
    text = f"{equations.title}; torque in, position out{_origin_of_values(equations, provenance or {}, accuracy)}"
    files, _ = _PACKAGINGS[kind](interface, platforms=platforms, text=text)
    python, linear = kind == "python", kind != "native3"  # FMI 3.0 has no call for the slopes of inputs
    files |= extra_files(
        interface, text=text, python=python, linear=linear, provenance=provenance or {}, accuracy=accuracy
    )
    data = pack(rename_picture(files) if kind == "native3" else files)
    write_bytes(out, data)
    return Fmu(
        path=out,
        digest=hashlib.sha256(data).hexdigest()[:16],
        equations=equations,
        kind=kind,
        step=interface.kernel.step,
        identification=identification,
    )


def _origin_of_values(equations: Equations, provenance: Mapping[str, Provenance | str], accuracy: Accuracy) -> str:
    """Return what the description says of the values: a reader must not take a first guess for a measurement."""
    origins = provenance_of(equations, provenance)
    if not origins:
        return ""
    guesses = sum(origin.status == GUESS for origin in origins.values())
    if accuracy is FIRST_GUESSES or not guesses:
        return f"; values: {accuracy.origin}"
    return f"; values: {accuracy.origin}, {guesses} of {len(origins)} first guesses"
