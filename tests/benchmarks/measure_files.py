# ruff: noqa: E501  (names of columns are as long as instruments make them)
"""How a hundred files, each with a known truth, are read: 60 layouts of instruments, and 40 of other kinds.

``python measure_files.py`` prints, for each file that is not read as it is, what became of it, and in the end how
many were read as they are, read after the one command that the refusal prints, refused otherwise, and misread. A
command with a radius, a normal force or a unit that only the user knows is right if speeds and coefficients are
those of the file times a constant.
"""

import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import stickslip_sym as ss

RNG = np.random.default_rng(52)
V = np.round(np.linspace(0.05, 1.2, 16), 4)
MU = np.round(0.2 + 0.3 * np.exp(-3 * V), 4)
TIME = np.round(0.1 * np.arange(1, 17), 2)
RPM = 60 / (2 * np.pi * 0.025)  # turns a minute for 1 m/s on a track of 25 mm
ROWS = "Time (s)", "Position (mm)"


def table(header, *columns, mark=",", end="", digits=7):
    rows = [mark.join(f"{x:.{digits}g}" if not isinstance(x, str) else x for x in row) + end
            for row in zip(*columns, strict=True)]  # fmt: skip
    return "\n".join(filter(None, [header, *rows])) + "\n"


def traction(steps, *, copies=True):
    """A traction machine: a preamble for each step, groups of columns parted by empty ones."""
    text = "MTM900 Test Data File\r\nLubricant name:\t\r\n\r\nNumber of steps:\t3\r\n"
    header = (
        "Step Time (s)\tTraction Coeff (-)\t\t\tStep Time (s)\tBall Load (N)\t\tBall Speed 1\tDisc Speed 1\t"
        "Rolling Speed (mm/s)\tSliding Speed (mm/s)\tSRR (%)\t\tTraction Force (N)\tTraction Coeff (-)"
    )
    for number, part in enumerate(np.array_split(np.arange(len(V)), steps), 1):
        text += f"\r\nStep {number} started at 10:0{number}:00\r\n"
        text += f"Disc track radius used for this step (mm)\t21.000\r\n{header}\r\n"
        for i in part:
            copied = f"{MU[i]}" if copies else ""
            text += (
                f"{5 * i}\t{MU[i]}\t\t\t{5 * i}\t20.01\t\t{1000 - 500 * V[i]:.1f}\t{1000 + 500 * V[i]:.1f}\t"
                f"1000.0\t{1000 * V[i]:.2f}\t{100 * V[i]:.3f}\t\t{20 * MU[i]:.4f}\t{copied}\r\n"
            )
    return text


def rotary(radius, sep="\r"):
    first = f"Recipe, UpperSample, Type, {radius}\r\n".replace("|", sep)
    rows = table("", TIME, 5 + 0 * V, 5 * MU, MU, RPM * V, -12 + 0 * V, end=",")
    return first + "Step, DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),Rotary.Velocity (rpm),XYZ.X Position (mm),\r\n" + rows


def tribometer(speed, factor, force, size, end=","):
    units = f"s,{speed},{force},{force},-{end}\n"
    return (
        f"Time,Velocity,Ff,Fn,COF{end}\n"
        + units
        + table("", TIME, factor * V, 5 * MU / size, 5 / size + 0 * V, MU, end=end)
    )


def steps_of(count, header="Time (s),Speed (mm/s),COF", factor=1000.0, radius=""):
    text = "Machine 9\n"
    for number, part in enumerate(np.array_split(np.arange(len(V)), count), 1):
        text += f"\nSegment {number}\n{radius}Load (N),20\n" + table(
            header, TIME[part], factor * V[part], MU[part]
        )
    return text


def layouts():
    """The layouts of instruments."""
    yield from ((f"traction machine, {n} steps", traction(n)) for n in (1, 2, 3, 4))
    yield "traction machine without copies", traction(2, copies=False)
    yield "rotary log", rotary("Radius|x,,25,")
    yield "rotary log, radius with a unit", rotary("Track radius: 25 mm")
    yield "rotary log, newlines", rotary("Radius|x,,25,", "\r\n")
    yield "rotary log, no radius", rotary("none")
    for speed, factor in (("mm/s", 1000), ("m/min", 60), ("cm/s", 100), ("mm/sec", 1000)):
        for force, size in (("gf", 0.00980665), ("N", 1), ("mN", 0.001)):
            yield f"tribometer {speed} {force}", tribometer(speed, factor, force, size)
    torque, turning = 5 * MU, 10 * V
    for header in ("time,position,velocity,torque", "t [s],q [rad],dq [rad/s],tau_J [Nm]",
                   "Time [s],Joint position [rad],Joint velocity [rad/s],Joint torque [N m]",
                   "timestamp;pos;vel;effort".replace(";", ","), "t,q,qd,tau",
                   "Time (s),Angle (deg),Angular velocity (rad/s),Friction torque (Nm)"):  # fmt: skip
        yield f"joint {header}", table(header, TIME, TIME**2, turning, torque)
    for header in ("Time;Position actual;Velocity actual;Current", "Index;Position [mm];Velocity [mm/s];Current [A]",
                   "Zeit;Position;Geschwindigkeit;Drehmoment", "t;Pos;Speed [mm/s];Motor torque [%]",
                   "Sample;Actual position;Actual velocity;Motor current", "Time;ActPos;ActVel;ActCurrent"):  # fmt: skip
        yield (
            f"servo {header}",
            "Drive 7\nFirmware 2.1\n\n" + table(header, TIME, TIME**2, 1000 * V, torque, mark=";"),
        )
    for header, factor in (("DAQ.Speed (mm/s),DAQ.COF ()", 1000), ("V1 mm/sec,COF", 1000), ("Carriage Speed (mm/s),COF", 1000),
                           ("Stage.Velocity [m/s],Fx/Fz", 1), ("V1 [MM/S],MU", 1000), ("v [10⁻³ m/s],mu", 1000),
                           ("Speed (in/s),COF (Fx/Fz)", 1 / 0.0254), ("Slip_speed_mm_s,friction coefficient", 1000)):  # fmt: skip
        yield f"names {header}", table(header, factor * V, MU)
    for header in ("Speed (rev/min),mu", "Speed [1/min],mu", "n (1/min),mu"):
        yield f"rotation {header}", "Track radius: 25 mm\n" + table(header, RPM * V, MU)
    yield "Hz", "Wear track radius (mm),25\n" + table("Rotation (Hz),mu", RPM * V / 60, MU)
    for unit, size in (
        ("g", 0.00980665),
        ("oz", 0.28349523125 * 0.980665),
        ("lbf", 4.4482216152605),
        ("lb", 4.4482216152605),
    ):
        yield (
            f"weights in {unit}",
            table(f"v [mm/s],Friction force [{unit}],Load [{unit}]", 1000 * V, 5 * MU / size, 5 / size + 0 * V),
        )
    yield from ((f"blocks {n}", steps_of(n)) for n in (2, 4))
    yield "blocks with a radius each", steps_of(2, "Time (s),Speed (rpm),COF", RPM, "Track radius (mm),25\n")
    yield "blocks with other headers", steps_of(1) + steps_of(1, "Time (s),Speed (m/s),COF", 1.0)
    yield "cells with errors", table("v [m/s],mu", V, [f"{x:.4f}(50)" for x in MU])
    yield "cells with plus minus", table("v [m/s];mu", V, [f"{x:.4f} ± 0.005" for x in MU], mark=";")
    yield "cells with units", table("speed;mu", [f"{1000 * x:g} mm/s" for x in V], MU, mark=";")
    yield (
        "cells with errors and decimal commas",
        table("v [m/s];mu", V, [f"{x:.4f}(50)" for x in MU], mark=";").replace(".", ","),
    )
    yield (
        "blocks, rotary, each with units in a row",
        steps_of(2, "Time,Speed,COF\ns,rev/min,-", RPM, "Track radius (mm),25\n"),
    )
    yield (
        "normal force in its own unit",
        table("v [mm/s],Ff [cN],Fn [kgf]", 1000 * V, 500 * MU, 5 / 9.80665 + 0 * V),
    )
    yield "an empty column", table("t\t\tv\tmu\tload", TIME, [""] * 16, V, MU, TIME + 2, mark="\t")


def others():
    """Other kinds."""
    for mark in ",;\t| ":
        yield f"parted by {mark!r}", table(f"v{mark}mu", V, MU, mark=mark)
        yield f"three columns parted by {mark!r}", table(f"t{mark}v{mark}mu", TIME, V, MU, mark=mark)
        yield f"no header, parted by {mark!r}", table("", V, MU, mark=mark)
    yield "decimal commas", table("v;mu", V, MU, mark=";").replace(".", ",")
    yield "decimal commas, tabs", table("v\tmu", V, MU, mark="\t").replace(".", ",")
    yield "header in a comment", table("# v [m/s] mu", V, MU, mark=" ")
    yield "comments between rows", table("v,mu", V, MU).replace("\n0.3567", "\n# pause\n0.3567")
    yield "byte order mark", "\ufeff" + table("v [mm/s],mu", 1000 * V, MU)
    yield "german", table("Gleitgeschwindigkeit [mm/s];Reibwert", 1000 * V, MU, mark=";").replace(".", ",")
    yield (
        "german forces",
        table("Geschwindigkeit [m/s];Reibkraft [N];Normalkraft [N]", V, 20 * MU, 20 + 0 * V, mark=";"),
    )
    yield "units in a row", table("speed,mu\nmm/s,-", 1000 * V, MU)
    yield "units with an underscore", table("speed_mm_s,mu", 1000 * V, MU)
    yield "um/s", table("v [µm/s],mu", 1e6 * V, MU, digits=9)
    yield "m/min", table("Speed [m/min],COF", 60 * V, MU)
    yield "forces", table("v [m/s],F_t [N],F_n [N]", V, 20 * MU, 20 + 0 * V)
    yield "forces in kN", table("v [m/s],F_t [N],F_n [kN]", V, 20 * MU, 0.02 + 0 * V)
    yield "negative normal force", table("v [m/s],Fx [N],Fz [N]", V, 20 * MU, -20 + 0 * V)
    yield "per cent", table("v [m/s],mu [%]", V, 100 * MU)
    yield "sigma", table("v [m/s],mu,sigma", V, MU, 0.01 + 0 * V)
    yield "v,std,mu", table("v [m/s],std,mu", V, 0.01 + 0 * V, MU)
    yield "descending", table("v,mu", V[::-1], MU[::-1])
    yield "both directions", table("v,mu", np.r_[V, -V], np.r_[MU, -MU])
    yield "summary rows", table("v,mu", V, MU) + "Mean,0.3\n"
    yield "stand-ins", table("v,mu", V, MU).replace("\n0.3567", "\n0.3,9.91E+37\n0.3567")
    yield "quoted", table('"v [m/s]","mu"', [f'"{x}"' for x in V], [f'"{x}"' for x in MU])
    yield "thousands", table("v [um/s],mu", [f'"{1e6 * x:,.1f}"' for x in V], MU)
    yield (
        "load in a preamble",
        "Load: 20 N\nDate: 1/2/2026\n" + table("Speed (mm/s),Friction coefficient", 1000 * V, MU),
    )
    yield "six columns, no names", table("", TIME, V, 20 * MU, 20 + 0 * V, mark=" ")


def judged(v, mu, *, by_hand):
    """Whether rows are those that were written, or these times constants that the user chose."""
    order = np.argsort(v, kind="stable")
    v, mu = v[order], mu[order]
    if len(v) == 2 * len(V):
        v, mu = v[::2], mu[::2]
    if len(v) != len(V):
        return False
    speeds, coefficients = v / V, mu / MU
    if not by_hand:
        speeds, coefficients = np.r_[speeds, 1], np.r_[coefficients, 1]
    return np.ptp(speeds) < 2e-3 * speeds.max() and np.ptp(coefficients) < 2e-3 * coefficients.max()


def outcome(path):
    """What becomes of a file, and what is said."""
    try:
        read = ss.read_measurements(path)
    except ss.InputError as error:
        said = str(error)
    else:
        return ("read" if judged(read.v, read.mu, by_hand=False) else "MISREAD"), str(read)
    if "read it by: read_measurements" in said or "of one: read_measurements" in said:
        call = said[said.rindex("read_measurements") :]
    elif "leave_out=True" in said:
        call = f"read_measurements({str(path)!r}, leave_out=True)"
    else:
        return "refused without a command", said
    try:
        read = eval(call, {"read_measurements": ss.read_measurements})
    except ss.InputError as error:
        return "refused, and the command fails", f"{said}: {error}"
    return ("read by one command" if judged(read.v, read.mu, by_hand=True) else "MISREAD by the command"), said


def main():
    for kind, files in (("layouts", list(layouts())), ("others", list(others()))):
        counts = Counter()
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files:
                path = Path(folder, "file.csv")
                path.write_bytes(text.encode())
                result, said = outcome(path)
                counts[result] += 1
                if result != "read":
                    print(f"{name}: {result}: {said.replace(folder, '')[:600]}\n")
        print(f"{len(files)} {kind}: {dict(counts)}\n")


if __name__ == "__main__":
    main()
