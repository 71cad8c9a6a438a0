"""Names of real tables, and the columns of the format that they stand for."""

from __future__ import annotations

import math

import pytest

from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.units_in_names import understand_column, understand_columns
from haptid.support.errors import InputError

DEG = math.pi / 180


@pytest.mark.parametrize(
    ("name", "known", "factor"),
    [
        ("position_0_deg", "position_0_rad", DEG),
        ("Angle (deg)", "position_0_rad", DEG),
        ("Joint 2 angle [°]", "position_2_rad", DEG),
        ("Angolo (gradi)", "position_0_rad", DEG),
        ("ángulo_1 (°)", "position_1_rad", DEG),
        ("Ángulo (grados)", "position_0_rad", DEG),
        ("Motormoment [Nm]", "torque_0_Nm", 1.0),
        ("Antriebsdrehmoment (Nm)", "torque_0_Nm", 1.0),
        ("Drehwinkel [mrad]", "position_0_rad", 1e-3),
        ("Achsstrom (A)", "current_0_A", 1.0),
        ("coppia [N mm]", "torque_0_Nm", 1e-3),
        ("par (N·m)", "torque_0_Nm", 1.0),
        ("Couple [mN·m]", "torque_0_Nm", 1e-3),
        ("velocità (rad/s)", "velocity_0_rad_s", 1.0),
        ("temps (ms)", "time_s", 1e-3),
        ("tiempo_s", "time_s", 1.0),
        ("q1_rad", "position_1_rad", 1.0),
        ("q_3_mrad", "position_3_rad", 1e-3),
        ("position_turns", "position_0_rad", 2 * math.pi),
        ("Position (mm)", "position_0_m", 1e-3),
        ("encoder counts", "position_0_rad", 0.002),
        ("position_2_counts", "position_2_rad", 0.002),
        ("position setpoint (deg)", "reference_0_rad", DEG),
        ("Desired angle (deg)", "reference_0_rad", DEG),
        ("commanded position (mm)", "reference_0_m", 1e-3),
        ("torque (Nmm)", "torque_0_Nm", 1e-3),
        ("Torque [N mm]", "torque_0_Nm", 1e-3),
        ("Torque [N·m]", "torque_0_Nm", 1.0),
        ("tau_1_mNm", "torque_1_Nm", 1e-3),
        ("Moment [Ncm]", "torque_0_Nm", 1e-2),
        ("torque_uNm", "torque_0_Nm", 1e-6),
        ("Drehmoment (mN·mm)", "torque_0_Nm", 1e-6),
        ("torque (lb-in)", "torque_0_Nm", 0.1129848290276167),
        ("torque (in.lbs)", "torque_0_Nm", 0.1129848290276167),
        ("torque [lbf ft]", "torque_0_Nm", 1.3558179483314004),
        ("torque_ozin", "torque_0_Nm", 0.007061551814226044),
        ("torque (kgf.cm)", "torque_0_Nm", 0.0980665),
        ("Force (lbf)", "force_0_N", 4.4482216152605),
        ("angle_mdeg", "position_0_rad", 1e-3 * DEG),
        ("angle (arcmin)", "position_0_rad", DEG / 60),
        ("angle_urad", "position_0_rad", 1e-6),
        ("time (min)", "time_s", 60.0),
        ("Drehmoment (kNm)", "torque_0_Nm", 1e3),
        ("commanded torque (Nm)", "torque_0_Nm", 1.0),
        ("Force (N)", "force_0_N", 1.0),
        ("Effort moteur (N)", "force_0_N", 1.0),
        ("effort axe 1 [mN m]", "torque_1_Nm", 1e-3),
        ("motor current (mA)", "current_0_A", 1e-3),
        ("i_mA", "current_0_A", 1e-3),
        ("pwm %", "duty_0", 1e-2),
        ("Supply (V)", "supply_V", 1.0),
        ("Motor temperature (°C)", "temperature_0_C", 1.0),
        ("time_ms", "time_s", 1e-3),
        ("Time (s)", "time_s", 1.0),
        ("elapsed (s)", "time_s", 1.0),
        ("t_us", "time_s", 1e-6),
        ("timestamp (µs)", "time_s", 1e-6),
        ("velocity_0_deg_s", "velocity_0_rad_s", DEG),
        ("Velocity (deg/s)", "velocity_0_rad_s", DEG),
        ("Position actual value [deg]", "position_0_rad", DEG),
        ("PositionActualValue [mm]", "position_0_m", 1e-3),
        ("Position demand value [deg]", "reference_0_rad", DEG),
        ("Target position [deg]", "reference_0_rad", DEG),
        ("Velocity actual value [rpm]", "velocity_0_rad_s", 2 * math.pi / 60),
        ("Target velocity [deg/s]", "reference_velocity_0_rad_s", DEG),
        ("commanded velocity (rad/s)", "reference_velocity_0_rad_s", 1.0),
        ("Torque actual value [mNm]", "torque_0_Nm", 1e-3),
        ("Current actual value [mA]", "current_0_A", 1e-3),
        ("DC link circuit voltage [mV]", "supply_V", 1e-3),
        ("bus voltage (V)", "supply_V", 1.0),
        ("q_meas_rad", "position_0_rad", 1.0),
        ("q_cmd_deg", "reference_0_rad", DEG),
        ("q_des_2 (deg)", "reference_2_rad", DEG),
        ("tau_meas_Nm", "torque_0_Nm", 1.0),
        ("iq (mA)", "current_0_A", 1e-3),
        ("i_q [A]", "current_0_A", 1.0),
        ("actual_position_deg", "position_0_rad", DEG),
        ("commanded_position_deg", "reference_0_rad", DEG),
        ("Istwert [°]", "position_0_rad", DEG),
        ("Sollwert [°]", "reference_0_rad", DEG),
        ("Lagesollwert [°]", "reference_0_rad", DEG),
        ("Sollposition_deg", "reference_0_rad", DEG),
        ("Stromistwert [A]", "current_0_A", 1.0),
        ("Drehmoment [Nm]", "torque_0_Nm", 1.0),
        ("speed rpm", "velocity_0_rad_s", 2 * math.pi / 60),
        ("millis", "time_s", 1e-3),
        ("millis()", "time_s", 1e-3),
        ("time_micros", "time_s", 1e-6),
        ("micros", "time_s", 1e-6),
        ("t_ms", "time_s", 1e-3),
        ("enc_counts", "position_0_rad", 0.002),
        ("enc1_ticks", "position_1_rad", 0.002),
        ("vbat_V", "supply_V", 1.0),
        ("battery_mV", "supply_V", 1e-3),
        ("current_mA", "current_0_A", 1e-3),
        ("target_deg", "reference_0_rad", DEG),
        ("pwm_pct", "duty_0", 1e-2),
        ("vel_dps", "velocity_0_rad_s", DEG),
        ("Winkel (Grad)", "position_0_rad", DEG),
        ("winkel_grad", "position_0_rad", DEG),
        ("Sollwert [Grad]", "reference_0_rad", DEG),
        ("angle (degrés)", "position_0_rad", DEG),
        ("position [gradi]", "position_0_rad", DEG),
        ("pos_1_grados", "position_1_rad", DEG),
        ("Winkel (gon)", "position_0_rad", math.pi / 200),
        ("Geschwindigkeit (Grad/s)", "velocity_0_rad_s", DEG),
        ("Geschwindigkeit_grad_s", "velocity_0_rad_s", DEG),
        ("Drehzahl [°/s]", "velocity_0_rad_s", DEG),
    ],
)
def test_names_are_understood(name: str, known: str, factor: float):
    target = understand_column(name, step=0.002)
    assert target is not None
    assert (target.name, target.factor) == (known, pytest.approx(factor, rel=1e-15))


@pytest.mark.parametrize(
    "name",
    [
        "tau",
        "deg",
        "ms",
        "M (Nm)",
        "x (mm)",
        "time",
        "torque (deg)",
        "i",
        "q1 q2 rad",
        "",
        "7",
        "Target torque [Nm]",
        "Following error actual value [deg]",
        "Lageabweichung [°]",
        "motor (A)",
        "position gradient (rad)",
        "Winkel (Winkelgrad)",
        "q_meas",
        "pwm",
        "enc",
        "setpoint",
        "vbat",
    ],
)
def test_what_is_not_sure_is_left_to_the_user(name: str):
    assert understand_column(name, step=0.002) is None


def test_an_unknown_word_is_no_hindrance_where_nothing_else_can_be_meant():
    columns = (
        "Time [s]",
        "Carriage position (mm)",
        "Carriage position error (mm)",
        "Desired position (mm)",
        "F belt (N)",
    )
    known = {column: target.name for column, target in understand_columns(columns, {}, None).items()}
    assert known == {
        "Time [s]": "time_s",
        "Carriage position (mm)": "position_0_m",
        "Desired position (mm)": "reference_0_m",
    }
    assert understand_columns((f"torque_{'9' * 5000}_Nm",), {}, None) == {}
    two = ("Shoulder angle (deg)", "Elbow angle (deg)")
    assert understand_columns(two, {}, None) == {}
    beside = ("Carriage position (mm)", "Position (mm)")
    assert list(understand_columns(beside, {}, None)) == ["Position (mm)"]


def test_a_name_of_the_format_and_a_stated_column_come_first():
    columns = ("time_s", "Angle (deg)", "position_0_rad", "tau (Nm)", "torque (mNm)")
    stated = {"tau (Nm)": Target(name="torque_0_Nm")}
    assert understand_columns(columns, stated, None) == stated


@pytest.mark.parametrize(
    ("columns", "known"),
    [
        (("Torque demand [Nm]", "Position actual [°]"), ["torque_0_Nm", "position_0_rad"]),
        (("Torque demand [Nm]", "Torque actual value [Nm]"), ["", "torque_0_Nm"]),
        (("Torque demand [Nm]", "Motor current [A]"), ["", "current_0_A"]),
        (("Torque demand [Nm]", "Target torque [Nm]"), ["", ""]),
    ],
)
def test_a_demanded_torque_is_the_input_where_nothing_was_measured(columns: tuple[str, ...], known: list[str]):
    found = understand_columns(columns, {}, None)
    assert [found[column].name if column in found else "" for column in columns] == known


def test_joint_states_of_ros_are_in_si_units_where_positions_and_efforts_lie_together():
    columns = ("joint_states/position[1]", "/joint_states/velocity[1]", "joint_states/effort[1]")
    assert list(understand_columns(columns, {}, None).values()) == [
        Target(name="position_1_rad"),
        Target(name="velocity_1_rad_s"),
        Target(name="torque_1_Nm"),
    ]
    assert list(understand_columns(("field.position0", "field.effort0"), {}, None)) == [
        "field.position0",
        "field.effort0",
    ]
    assert len(understand_columns(("position[0]", "effort[0]"), {}, None)) == 2
    assert understand_columns(("position[0]", "tau"), {}, None) == {}
    assert understand_columns(("position_0", "effort_0"), {}, None) == {}


def test_two_names_of_one_signal_are_refused_with_the_remedy():
    with pytest.raises(InputError, match="expected one that stands for torque_0_Nm") as refused:
        understand_columns(("measured torque (Nm)", "commanded torque (Nm)"), {}, None)
    assert "--map 'commanded torque (Nm)=torque_0_Nm*1'" in str(refused.value)


def test_counts_need_their_size():
    with pytest.raises(InputError, match="expected the angle of one count"):
        understand_columns(("encoder counts",), {}, None)
