"""The sets of real measurements: folder, campaign, joints, figures to reach, and what was published."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.machines import campaigns, figures
from benchmarks.machines.figure import Figure
from benchmarks.machines.published import published_combinations


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineSet:
    """A set of real measurements.

    Parameters
    ----------
    folder
        Folder below the data.
    title
        Heading on the page.
    write
        Function that writes the campaign from the folder of the data into another folder.
    joints
        Joints that the search for missing effects is run on.
    figures
        Function from results to the figures to reach.
    published
        Published parameters by id, SI units; those of the plain model for a single joint.
    source
        Where measurements and published figures come from.
    """

    folder: str
    title: str
    write: Callable[[Path, Path], None]
    joints: tuple[int, ...]
    figures: Callable[[figures.Results], list[Figure]]
    source: str
    published: Mapping[str, float] = field(default_factory=dict)


SETS = (
    MachineSet(
        folder="emps",
        title="Prismatic drive (EMPS)",
        write=campaigns.write_emps,
        joints=(0,),
        figures=figures.emps_figures,
        source="Janot, Gautier, Brunot 2019: inverse dynamics, force error 4.08 %, with asymmetric friction 3.11 %",
        published={**figures.EMPS_PUBLISHED, "offset": -3.1648},
    ),
    MachineSet(
        folder="dvrk_mtm_joint4",
        title="Tendon-driven joint of a surgical master arm (dVRK MTM joint 4)",
        write=campaigns.copy_campaign,
        joints=(4,),
        figures=figures.dvrk_figures,
        source="WPI-AIM/dvrk_dynamics_identification: two polynomials of degree 7, one a direction, 4.2 mN m on all "
        "rows that they were fitted to; 4.63 mN m on every third of 48 stretches",
    ),
    MachineSet(
        folder="bam_xl330",
        title="Servo with an arm and a mass (Dynamixel XL330)",
        write=campaigns.write_xl330,
        joints=(0,),
        figures=figures.xl330_figures,
        source="Rhoban/bam: its friction models M1 to M6 leave 40.7 to 62.8 mrad on gain 400",
    ),
    MachineSet(
        folder="dfki_simple_pendulum",
        title="Direct-drive pendulum (DFKI)",
        write=campaigns.write_simple_pendulum,
        joints=(0,),
        figures=figures.simple_pendulum_figures,
        source="DFKI: mass 0.6755 kg at 0.5 m; linear least squares leaves 13.5 and 15.2 % of the torque where fitted",
        published={"gravity_sin": figures.PENDULUM_WEIGHT_NM},
    ),
    MachineSet(
        folder="dfki_double_pendulum_a0",
        title="Two-joint direct-drive arm (DFKI double pendulum A.0)",
        write=campaigns.copy_campaign,
        joints=(0, 1),
        figures=figures.double_pendulum_figures,
        source="DFKI: link values and friction Fc·atan(100·v) + σ2·v of design A.0",
        published=published_combinations(),
    ),
)
"""Sets in the order of the page."""
