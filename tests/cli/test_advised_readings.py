"""What a refusal of a file ends in is a whole command that reads it, in Python and in the shell."""

import shlex

import numpy as np
import pytest

import stickslip_sym as ss

V = np.linspace(0.1, 2, 20)
MU = np.round(0.2 + 0.3 * np.exp(-V), 4)
TORQUE = np.round(5 * MU, 4)


def rows(*columns, mark=","):
    return [mark.join(f"{value:g}" for value in row) for row in zip(*columns, strict=True)]


LAYOUTS = {
    "robot joint": ["time,position,velocity,torque", *rows(V / 10, V**2, 10 * V, TORQUE)],
    "robot joint with units": ["t [s],q [rad],dq [rad/s],tau_J [Nm]", *rows(V / 10, V**2, 10 * V, TORQUE)],
    "servo log": [
        "Drive 7", "Firmware 2.1", "", "Time;Position actual;Velocity actual;Velocity set;Current",
        *rows(V / 10, V**2, 1000 * V, 1000 * np.round(V), TORQUE, mark=";"),
    ],
    "drive in per cent": ["Index\tMotor Speed (rpm)\tTorque (%)", *rows(V, 100 * V, 50 * MU, mark="\t")],
    "other words": ["Zeit,Geschw,Kraft,Last", *rows(V / 10, 1000 * V, 20 * MU, 20 + 0 * V)],
    "no names": rows(V * 10, V, 20 * MU, 20 + 0 * V, mark=" "),
    "no units": ["Speed,Friction", *rows(1000 * V, MU)],
    "two coefficients": ["v,mu,COF", *rows(V, MU, 2 * MU)],
    "rpm": ["rpm,mu", *rows(300 * V, MU)],
    "radius without a unit": ["Recipe,Radius", "x,12", "", "t (s),Speed (rpm),DAQ.COF ()", *rows(V, 300 * V, MU)],
    "one force": ["v [m/s],F_t [N]", *rows(V, 20 * MU)],
    "rolling": ["Mean Speed [mm/s],SRR (%),mu", *rows(1000 * V, 0 * V + 50, MU)],
}  # fmt: skip


@pytest.fixture(params=LAYOUTS)
def file(request, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "a log's.csv"
    path.write_text("\n".join(LAYOUTS[request.param]), encoding="utf-8")
    return path.name


def test_the_command_that_a_refusal_prints_reads_the_file(file, run):
    with pytest.raises(ss.InputError) as refusal:
        ss.read_measurements(file)
    _, call = str(refusal.value).split("read it by: read_measurements")
    read = eval(f"read{call}", {"read": ss.read_measurements})
    assert len(read) == len(V)
    code, out, err = run("read", file)
    assert (code, out) == (2, "")
    program, *arguments = shlex.split(err.split("read it by: ")[1])
    assert program == "stickslip"
    code, out, err = run(*arguments)
    assert (code, err) == (0, "")
    assert str(read) in " ".join(out.split())


def test_all_that_is_missing_is_named_at_once(tmp_path):
    (tmp_path / "joint.csv").write_text("\n".join(LAYOUTS["robot joint"]))
    with pytest.raises(ss.InputError) as refusal:
        ss.read_measurements(tmp_path / "joint.csv")
    for said in ("line 1, column 3, 'velocity': a speed without a unit", "'torque': a torque without a unit",
                 "no column is F_n"):  # fmt: skip
        assert said in str(refusal.value)


def test_torque_is_a_force_times_the_radius_and_a_chosen_unit_may_have_a_number(tmp_path):
    path = tmp_path / "joint.csv"
    path.write_text("\n".join(LAYOUTS["robot joint with units"]))
    read = ss.read_measurements(path, columns={"v": 3, "F_t": 4, "F_n": "40 N"}, radius="0.05 m")
    assert read.v == pytest.approx(10 * V * 0.05, rel=1e-5)
    assert read.mu == pytest.approx(TORQUE / 0.05 / 40, rel=1e-12)
    path.write_text("\n".join(LAYOUTS["servo log"]))
    read = ss.read_measurements(path, columns={"v": "3 [mm/s]", "F_t": "Current [2.5 N]", "F_n": "5 kg"})
    assert read.mu == pytest.approx(TORQUE * 2.5 / 5 / 9.80665, rel=1e-12)
    with pytest.raises(ss.InputError, match="columns are '5 m'"):
        ss.read_measurements(path, columns={"v": "3 [mm/s]", "F_t": "Current [2.5 N]", "F_n": "5 m"})
    path.write_text("v [m/s],F_t (10 N),F_n [N]\n1,2,3\n")
    with pytest.raises(ss.InputError, match="'10 N' is no unit known here"):
        ss.read_measurements(path)  # in a header it may be the load


def test_a_torque_beside_a_friction_force_is_not_read(tmp_path):
    path = tmp_path / "both.csv"
    path.write_text(
        "\n".join(["v [m/s],Friction Force [N],Torque [N m],Load [N]", *rows(V, 10 * MU, MU, 0 * V + 10)])
    )
    assert ss.read_measurements(path).mu == pytest.approx(MU, rel=1e-5)
