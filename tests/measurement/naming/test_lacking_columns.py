"""What an error proposes for a column whose name does not say enough."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.measurement.naming.lacking_columns import propose_target, tell_how_to_name


@pytest.mark.parametrize(
    ("column", "option"),
    [
        ("torque (dyn.cm)", "--map 'torque (dyn.cm)=torque_0_Nm*FACTOR' (FACTOR: Nm of one 'dyn.cm')"),
        ("Drehmoment (mNmx)", "--map 'Drehmoment (mNmx)=torque_0_Nm*FACTOR' (FACTOR: Nm of one 'mNmx')"),
        ("torque (motor)", "--map 'torque (motor)=torque_0_Nm'"),
        ("shoulder torque (lb-in)", "--map 'shoulder torque (lb-in)=torque_0_Nm*0.112985'"),
    ],
)
def test_a_unit_that_is_not_known_gets_no_factor_of_another(column: str, option: str):
    assert tell_how_to_name(["torque"], ["time_s", column], (), None) == f"no torque: use {option}"


def test_nothing_is_proposed_in_a_unit_that_is_not_known():
    assert propose_target("torque", "torque (dyn.cm)", ["time_s", "torque (dyn.cm)"], None) == ("", "")
    assert propose_target("torque", "torque", ["time_s", "torque"], None) == ("torque_0_Nm", "")


@pytest.mark.parametrize(
    ("signal", "name", "target"),
    [
        ("torque", "coppia", "torque_0_Nm"),
        ("torque", "par motor", "torque_0_Nm"),
        ("torque", "corriente", "current_0_A"),
        ("position", "ángulo [mrad]", "position_0_rad*0.001"),
        ("position", "vitesse (rad/s)", ""),
        ("torque", "thermocouple", ""),
        ("torque", "cable tension", ""),
    ],
)
def test_words_of_other_languages_are_proposed_and_nothing_that_holds_them(signal: str, name: str, target: str):
    assert propose_target(signal, name, ["time_s", name], None)[0] == target


def test_a_count_of_rows_is_no_time_in_seconds():
    """``sample`` below ``Sampling rate: 250 Hz`` was proposed as seconds, so that rows were 1 s apart."""
    table = {"sample": np.arange(500.0), "torque_0_Nm": np.zeros(500), "position_0_rad": np.zeros(500)}
    told = tell_how_to_name(["time"], list(table), {0}, table.__getitem__)
    assert told == "no time: use --map 'sample=time_s*FACTOR' (FACTOR: seconds from row to row, as 1/250 at 250 Hz)"
    table["sample"] = np.arange(500.0) * 0.004
    assert "'sample=time_s'" in tell_how_to_name(["time"], list(table), {0}, table.__getitem__)


def test_dates_of_a_spreadsheet_are_days():
    """46356.49 and its neighbours 5e-8 apart were proposed as milliseconds."""
    table = {"Zeitpunkt": 46356.49 + np.arange(500) * 0.004 / 86400.0}
    assert propose_target("time", "Zeitpunkt", list(table), table.__getitem__) == (
        "time_s*86400",
        "days, as spreadsheets count them",
    )
    table["Zeitpunkt"] = 46356.49 + np.arange(500) * 4.0
    assert propose_target("time", "Zeitpunkt", list(table), table.__getitem__)[0] == "time_s*0.001"
