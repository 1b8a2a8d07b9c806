"""Files of measurements as instruments write them: read to the same numbers, or refused with line and column."""

import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Rational

import stickslip_sym as ss
from stickslip_sym.model.measured.measurements import Measurements
from support.sweeps import sweep

SPEED_UNITS = {"m/s": 1, "mm/s": 1000, "cm/s": 100, "um/s": 10**6, "m/min": 60, "km/h": Fraction(18, 5),
               "in/s": 1 / Fraction("0.0254"), "mm s^-1": 1000, "m·s⁻¹": 1, "mm/min": 60000, "nm/s": 10**9,
               "µm/s": 10**6, "mm_s": 1000, "mm/sec": 1000, "MM/S": 1000, "M/MIN": 60,
               "10⁻³ m/s": 1000, "10^-6 m/s": 10**6}  # fmt: skip
FORCE_UNITS = {
    "N": 1,
    "kN": Fraction(1, 1000),
    "mN": 1000,
    "uN": 10**6,
    "daN": Fraction(1, 10),
    "kg": 1 / Fraction("9.80665"),
    "g": 1000 / Fraction("9.80665"),
    "gf": 1000 / Fraction("9.80665"),
}
WORDS = {
    "v": ["v", "speed", "Velocity", "sliding speed", "v_r", "V_rel", "slip velocity", "v_slip", "Sliding_Speed",
          "Lin. Speed", "Mean Speed", "Belt speed", "Carriage Speed", "V1", "Stage.Velocity", "DAQ1.v"],
    "mu": ["mu", "COF", "friction coefficient", "Coefficient of Friction", "μ", "µ", "Friction Factor", "COF_avg",
           "Friction Coefficient µ", "Reibungskoeffizient", "mu_mean", "|COF|", "µ_dyn", "Traction coefficient",
           "Friction coef.", "DAQ.COF", "COF (Fx/Fz)", "mu = Ft/Fn", "Fx/Fz"],
    "F_t": ["F_t", "Friction force", "Fx", "tangential force", "F_f", "DAQ.Fx"],
    "F_n": ["F_n", "Normal Force", "Fz", "normal load", "Load"],
    "sigma": ["sigma_mu", "std(mu)", "s_mu", "σ", "std", "uncertainty", "standard deviation", "std of COF"],
    "other": ["time[s]", "temperature (degC)", "Cycle", "humidity in %"],
}  # fmt: skip
DIALECTS = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("|", ","), (" ", "."), (" ", ",")]
FRAMES = ["{} [{}]", "{} ({})", "{} in {}", "{} / {}", "{}[{}]", '"{}, {}"', "{}_{}"]
SEEDS = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tables")


def write(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "pin.csv"
    path.write_bytes(text.encode(encoding))
    return path


def random_table(rng):
    """A table in a random dialect, the numbers that it means in SI units, its columns and the unit of speed."""

    def pick(items):
        items = list(items)
        return items[rng.integers(len(items))]

    count, (separator, sign), minus = int(rng.integers(4, 12)), pick(DIALECTS), pick("--−")
    blanks = separator == " "
    names = [*pick([["v", "mu"], ["v", "F_t", "F_n"]]), *pick([["sigma"], [], []]), *pick([["other"], []])]
    forces, both = "F_t" in names, rng.random() < 0.4
    size = {"v": pick(SPEED_UNITS.items()), "F_t": pick(FORCE_UNITS.items()), "F_n": pick(FORCE_UNITS.items())}
    down, rows, meant = pick([1, -1]) if forces else 1, [], []
    for i in range(count):
        way, v = pick([1, -1]) if both else 1, round(float(rng.uniform(0.001, 2)), 4)
        mu, load = round(0.5 - 0.15 * v + float(rng.uniform(-0.02, 0.02)), 4), round(float(rng.uniform(5, 50)), 2)
        exact = {"v": v, "mu": mu, "F_t": mu * load, "F_n": load, "sigma": round(rng.uniform(0.001, 0.1), 4)}
        units = {name: Fraction(size[name][1] if name in size else 1) for name in exact}
        texts = {name: f"{float(Fraction(value) * units[name]):.6g}" for name, value in exact.items()}
        value = {name: Fraction(text) / units[name] for name, text in texts.items()}
        meant.append((value["v"], value["F_t"] / value["F_n"] if forces else value["mu"], value["sigma"]))
        for name, turn in (("v", way), ("mu", way), ("F_t", way * down)):
            texts[name] = "-" * (turn < 0) + texts[name]
        rows.append(texts | {"other": str(i)})
    unit = size["v"][0]
    frame = pick(one for one in FRAMES if not blanks or one[2:4] in ("[{", " [", " (", "_{"))
    frame = FRAMES[0] if "_" in frame[2:] and any(mark in unit for mark in " ^·") else frame
    header = {}
    for name in names:
        word = pick(one for one in WORDS[name] if not blanks or " " not in one)
        header[name] = frame.format(word, size[name][0]).strip('"') if name in size else word
    if forces and "sigma" in names:
        header["sigma"] = "sigma_mu"
    if not blanks and "mu" in names and rng.random() < 0.2:
        header["mu"] += " [%]"
        for i, row in enumerate(rows):
            row["mu"] = f"{100 * float(row['mu']):.6g}"
            meant[i] = (meant[i][0], abs(Fraction(row["mu"])) / 100, meant[i][2])
    rng.shuffle(names)
    if "sigma" in names[names.index("v") + 1 :][:1]:  # one behind the speed would be that of the speed
        header["sigma"] = "sigma_mu"
    lines = [separator.join(f'"{header[name]}"' if separator in header[name] else header[name] for name in names)]
    for row in rows:
        between = separator * (int(rng.integers(1, 4)) if blanks else 1)
        cells = [row[name].replace(".", sign).replace("-", minus) for name in names]
        lines.append(between.join(cells) + pick(["", "", separator]))
    lines = [*pick([["# made by a machine, 3;4,5"], []]), *lines]
    lines.insert(int(rng.integers(1, len(lines) + 1)), pick(["% a remark", ""]))
    end = pick(["\n", "\r\n"])
    return end.join(lines) + end, meant, names, unit


TITLES = [
    "Run 3 of the tribometer, disc 7; speed, friction", "v [m/s] and mu, from a machine", "1 2 3 4 5 6 7", "v;mu",
    "Sliding speed (mm/s)\tCOF", "a | b | c | speed | mu",
]  # fmt: skip


@given(SEEDS, st.sampled_from(TITLES), st.booleans())
def test_chosen_columns_win_whatever_the_title_looks_like(folder, seed, title, named):
    """By number or by name, with the separator that fits the rows."""
    rng = np.random.default_rng(seed)
    separator, sign = DIALECTS[rng.integers(len(DIALECTS))]
    v, mu = np.round(rng.uniform(0.1, 2, 8), 3), np.round(rng.uniform(0.2, 0.5, 8), 3)
    rows = [
        separator.join(f"{x:g}".replace(".", sign) for x in (i + 1, a, 7, b))
        for i, (a, b) in enumerate(zip(v, mu, strict=True))
    ]
    header = separator.join(["No", "A", "B", "C"])
    path = write(folder, "\n".join([title, header, *rows]))
    columns = {"v": "A [mm/s]" if named else "2 [mm/s]", "mu": "C" if named else 4}
    read = ss.read_measurements(path, columns=columns, keep_outliers=True)
    order = np.argsort(v, kind="stable")
    np.testing.assert_array_equal(read.v, [float(Fraction(f"{x:g}") / 1000) for x in v[order]])
    np.testing.assert_array_equal(read.mu, mu[order])


@pytest.mark.parametrize(
    "name", ["Speed (rpm)", "Spindle speed, rpm", "speed_rpm", "RPM", "rpm of the spindle", "n (1/min)",
             "Speed [1/min]", "Rotation speed [1/min]", "Rotation [rpm]", "Drehzahl in U/min",
             "rotational speed [rev/min]", "Speed (REV/MIN)"],
)  # fmt: skip
def test_rotations_stand_in_any_position(tmp_path, name):
    path = write(tmp_path, f"{name};mu\n60;0.4\n120;0.3\n")
    read = ss.read_measurements(path, radius="0.1")
    assert read.v == pytest.approx(np.array([1, 2]) * 2 * np.pi * 0.1, rel=1e-15)
    with pytest.raises(ss.InputError, match="a rotational speed; give the radius"):
        ss.read_measurements(path)


def test_commas_between_thousands_are_read_where_they_are_quoted(tmp_path):
    for text, v in (('"1,234.5",0.4\n"2,000",0.3\n', [1234.5, 2000]), ('"1,234,000",1\n950,2\n', [950, 1234000])):
        assert ss.read_measurements(write(tmp_path, "v [um/s],mu\n" + text)).v.tolist() == [x * 1e-6 for x in v]
    with pytest.raises(ss.InputError, match="may be a decimal sign, or stand between thousands"):
        ss.read_measurements(write(tmp_path, 'v [um/s],mu\n"1,234",1\n"2,000",2\n'))
    read = ss.read_measurements(write(tmp_path, 'v [m/s],mu\n"1,2","0,4"\n"2,0","0,3"\n'))
    assert (read.v.tolist(), read.mu.tolist()) == ([1.2, 2], [0.4, 0.3])


def test_rows_with_a_number_too_many_are_never_left_out(tmp_path):
    """They would be those of the largest speeds, with a sign between thousands."""
    rows = [f"{v:,},{0.5 - v / 5000}\n" for v in range(100, 1100, 50)]
    path = write(tmp_path, "v [mm/s],mu\n" + "".join(rows))
    for leave_out in (False, True):
        with pytest.raises(ss.InputError, match=r"line 20: .* write such numbers in quotes; got '1,000,0"):
            ss.read_measurements(path, leave_out=leave_out)
    path = write(tmp_path, "v [mm/s],mu\n" + "".join(rows[:18]) + "500,0.4,a remark\n")
    assert len(ss.read_measurements(path, leave_out=True)) == 18


def test_columns_without_a_unit_have_none_in_a_row_of_units(tmp_path):
    for units in ("mm/s;1;", "mm/s;;", "mm/s", "[mm/s];[-]"):
        read = ss.read_measurements(write(tmp_path, f"Speed;COF;Remark\n{units}\n100;0,4;a\n200;0,3;\n"))
        assert (read.v.tolist(), read.mu.tolist()) == ([0.1, 0.2], [0.4, 0.3])


def test_what_is_assumed_is_said(tmp_path):
    for text, words in (
        ("0.1,0.4\n0.2,0.3\n", "no header, v taken to be in m/s, mu from column 2"),
        ("v,mu\n0.1,0.4\n", "1 row, v taken to be in m/s, mu"), ("v [m/s],mu\n0.1,0.4\n", "1 row, v in m/s, mu"),
        ("v [m/s],F_t [N],Load [kg]\n1,2,1\n", "F_n in kg taken for weights"),
    ):  # fmt: skip
        assert words in str(ss.read_measurements(write(tmp_path, text)))


@given(SEEDS)
def test_fast_rows_beyond_a_gap_are_no_outliers(folder, seed):
    """Nothing is left out of a curve that falls between two groups of speeds; a spike among the rows is."""
    rng = np.random.default_rng(seed)
    slow, fast = np.sort(rng.uniform(0.01, 0.1, 30)), np.sort(rng.uniform(0.6, 3, int(rng.integers(1, 6))))
    v = np.concatenate([slow, fast])
    mu = np.where(v > 0.5, 0.15, 0.5 - 0.5 * v) + 0.002 * rng.normal(size=len(v))
    rows = [f"{a:.5f},{b:.5f}\n" for a, b in zip(v, mu, strict=True)]
    for leave_out in (False, True):
        assert len(
            ss.read_measurements(write(folder, "v [m/s],mu\n" + "".join(rows)), leave_out=leave_out)
        ) == len(v)
    rows[15] = f"{v[15]:.5f},{mu[15] + 0.3:.5f}\n"
    with pytest.raises(ss.InputError, match=r"line 17.*off a smooth curve"):
        ss.read_measurements(write(folder, "v [m/s],mu\n" + "".join(rows)))
    percents = [f"{a:.5f},{100 * b:.5f}\n" for a, b in zip(v, mu, strict=True)]
    with pytest.raises(ss.InputError, match=f"and {len(v)} of {len(v)} rows are like it, too many to leave out"):
        ss.read_measurements(write(folder, "v [m/s],mu\n" + "".join(percents)), leave_out=True)


def with_fault(text, rng):
    """A table with one planted fault, the line, and whether its row has a cell less or more."""
    lines = text.split("\n")
    row = int(rng.choice([i for i, line in enumerate(lines) if line[:1].isdigit() or line[:1] in ("-", "−")]))
    separator = next(mark for mark in "\t;| ," if mark in lines[row])
    cells = lines[row].rstrip(";,|\t \r").split(separator)
    cells = [cell for cell in cells if cell] if separator == " " else cells
    i = int(rng.integers(len(cells)))
    wrong = [[], [cells[i]] * 2, ["n/a"], ["Mean"], ["9.91E+37"], ["-999"], ["1.234,5"]][rng.integers(7)]
    cells[i : i + 1] = wrong
    lines[row] = separator.join(f'"{cell}"' if separator in cell else cell for cell in cells)
    return "\n".join(lines), row + 1, len(wrong) != 1


@given(SEEDS)
def test_any_dialect_is_read_to_the_same_numbers(folder, seed):
    rng = np.random.default_rng(seed)
    text, meant, names, unit = random_table(rng)
    encoding = str(rng.choice(["utf-8", "utf-8-sig", "utf-16"]))
    read = ss.read_measurements(write(folder, text, encoding))
    order = sorted(range(len(meant)), key=lambda i: meant[i][0])
    for got, place in ((read.v, 0), (read.mu, 1), *([(read.sigma, 2)] if "sigma" in names else [])):
        np.testing.assert_array_equal(got, [float(meant[i][place]) for i in order], err_msg=text)
    assert ("sigma" in names) == (read.sigma is not None)
    assert f"v in {unit}," in f"{read},"
    assert ("mu from F_t/F_n" in str(read)) == ("F_t" in names)


@given(SEEDS)
def test_planted_faults_are_refused_with_their_line(folder, seed):
    """Never read wrong: refused there, or, where the cell is of a column that is not read, the same numbers."""
    rng = np.random.default_rng(seed)
    text = random_table(rng)[0]
    before = ss.read_measurements(write(folder, text))
    faulty, line, other_width = with_fault(text, rng)
    try:
        after = ss.read_measurements(write(folder, faulty))
    except ss.InputError as error:  # a table with two decimal signs is refused at the first of the other
        assert f"line {line}" in str(error) or "has a point" in str(error), faulty  # noqa: PT017
        return
    assert not other_width, faulty
    for old, new in ((before.v, after.v), (before.mu, after.mu), (before.sigma, after.sigma)):
        np.testing.assert_array_equal(old, new, err_msg=faulty)


def test_nines_among_speeds_in_both_directions_stand_for_none_where_all_others_have_decimals(tmp_path):
    rows = [f"{sign * (990 + 3.7 * i):.1f},0.3" for i, sign in enumerate([1, -1] * 6)]
    faulty = [*rows[:4], "-999,0.3", *rows[4:]]
    with pytest.raises(ss.InputError, match=r"line 6.*stands for no value"):
        ss.read_measurements(write(tmp_path, "\n".join(["v [mm/s],mu", *faulty])))
    whole = [f"{row.split('.')[0].split(',')[0]},0.3" for row in faulty]
    assert len(ss.read_measurements(write(tmp_path, "\n".join(["v [mm/s],mu", *whole])))) == 13


def test_rows_with_faults_are_left_out_and_counted(tmp_path):
    rng = np.random.default_rng(77)
    v = np.round(np.linspace(0.01, 1, 40), 4)
    mu = np.round(0.2 + 0.3 * np.exp(-3 * v) + 0.005 * rng.normal(size=40), 4)
    rows = [f"{a},{b}" for a, b in zip(v, mu, strict=True)]
    plain = ss.read_measurements(write(tmp_path, "v,mu\n" + "\n".join(rows)))
    bad = {"0.0700,9999": "abs(mu) above 5|stands for none", "0.5,9.91E+37": "stands for none",
           "0.5,-999": "stands for none", "0.5,NaN": "without a number", "Mean,0.3": "without a number",
           "0.55,0.9": "off a smooth curve", "0.5,0.3,0.2": "of another number of columns"}  # fmt: skip
    for row, reason in bad.items():
        position = int(rng.integers(3, 37))
        path = write(tmp_path, "\n".join(["v,mu", *rows[:position], row, *rows[position:], ";;;;", ",,"]))
        with pytest.raises(ss.InputError, match=rf"line {position + 2}.*leave_out=True"):
            ss.read_measurements(path)
        read = ss.read_measurements(path, leave_out=True)
        assert read.mu.tolist() == plain.mu.tolist()
        assert any(words in str(read) for words in reason.split("|"))
        assert f"1 {str(read).split('rows left out: 1 ')[1]}" in str(read)
    path = write(tmp_path, "\n".join(["v,mu", *rows, "0.55,0.9"]))
    assert len(ss.read_measurements(path, keep_outliers=True)) == 41
    for leave_out in (True, False):
        path = write(tmp_path, "\n".join(["v,mu", *rows, "", "Run 2", "v [mm/s],mu", *rows]))
        with pytest.raises(ss.InputError, match=r"different headers \(block 1: v, mu; block 2: v .mm/s., mu\)"):
            ss.read_measurements(path, leave_out=leave_out)


@given(SEEDS)
def test_what_is_left_out_is_not_systematic(folder, seed):
    """A block, rows at even steps, and one end of the speeds are refused; scattered rows and a summary are not."""
    rng = np.random.default_rng(seed)
    v = rng.permutation(np.round(np.linspace(0.01, 1, 60), 4))
    bad = str(rng.choice(["n/a", "9.91E+37", "x"]))
    step, begin = int(rng.integers(2, 8)), int(rng.integers(0, 10))
    ends = np.argsort(v)
    lost = {
        "follow each other": range(begin, begin + int(rng.integers(5, 12))),
        f"every {step} rows": range(begin, begin + 6 * step, step),
        "highest speeds": ends[-4:],
        "lowest speeds": ends[:3],
        "": [3, 17, 22, 48, int(ends[-1])],
    }

    def read(rows, more=()):
        lines = [f"{a},{bad if i in rows else f'{0.4 - 0.1 * a:.5f}'}" for i, a in enumerate(v)]
        return ss.read_measurements(write(folder, "\n".join(["v,mu", *lines, *more])), leave_out=True)

    for words, rows in lost.items():
        chosen = set(map(int, rows))
        apart = sorted(chosen)
        if not words:
            assert len(read(chosen, ["Mean,0.3", "SD,0.1", "Min,0.2", "Max,0.4"])) == len(v) - len(chosen)
            continue
        if "speeds" in words and (np.diff(apart) == 1).sum() > 2:
            continue
        with pytest.raises(ss.InputError, match=rf"{len(chosen)} of 60 rows would be left out .*{words}"):
            read(chosen)


SOME = ["exponential", "stribeck", "andersson", "quintic"]


@sweep("chosen", [SOME, list(ss.laws)], SOME)
def test_smooth_curves_have_no_outliers(tmp_path, chosen):
    """Of every law with four decimals, on even and on geometric grids from rest, and with noise in 98 of 100."""
    rng = np.random.default_rng(8)
    refused = count = 0
    for law in chosen:
        for grid in (np.linspace(0, 0.8, 25), np.linspace(0.02, 0.8, 12), np.geomspace(1e-3, 0.8, 40)):
            mu = ss.laws[law].typical().mu(grid) + float(rng.choice([0, 0.003, 0.02])) * rng.normal(size=len(grid))
            text = "v,mu\n" + "".join(f"{a:.6g},{abs(b):.4f}\n" for a, b in zip(grid, mu, strict=True))
            count += 1
            try:
                ss.read_measurements(write(tmp_path, text))
            except ss.InputError:
                refused += 1
    assert refused <= 0.02 * count


READ = [
    ("Instrument;pin on disc\r\n# 12.03.2021, disc 7\r\nt [s];Fx [N];Fz [N];Speed [mm/s]\r\n0,1;3,5;-10,0;100\r\n"
     "0,2;-4,0;-10,0;-50,0\r\n0,3;2,5;-10,0;250\r\n", "utf-8", [0.05, 0.1, 0.25], [0.4, 0.35, 0.25],
     "3 rows, v in mm/s, mu from F_t/F_n, both signs of speed folded, columns not read: t [s]"),
    ("t;Fx;Fz;Speed\ns;N;N;mm/s\n0,1;3,5;-10,0;100\n", "utf-8", [0.1], [0.35], "v in mm/s, mu from F_t"),
    ("# v, mu\n0.1,0.4\n", "utf-8", [0.1], [0.4], "1 row"),
    ("Speed [mm/s]\tCOF []\n100\t0,4\n200\t0,35\n", "utf-16", [0.1, 0.2], [0.4, 0.35], "2 rows"),
    ("v [um/s],mu\n999,0.4\n5000,0.35\n", "utf-8", [0.000999, 0.005], [0.4, 0.35], "2 rows"),
    ("v [µm/s];µ\n5;0,25\n", "cp1252", [5e-6], [0.25], "1 row"),
    ("Test,pin 3,\nTime,Carriage Speed,Fz,Fx,\nsec,mm/sec,gf,gf,\n0.1,10,-1000,400,\n0.2,20,-1000,380,\n", "utf-8",
     [0.01, 0.02], [0.4, 0.38], "2 rows, v in mm/sec, mu from F_t/F_n, columns not read: Time [sec]"),
    ("Tester\nT, sec\tV1 mm/sec\tFx N\tFz N\n0.1\t10\t4\t10\n0.2\t20\t3\t10\n", "utf-8", [0.01, 0.02], [0.4, 0.3],
     "v in mm/sec, mu from F_t/F_n"),
    ("speed [mm/s];Ff [g];load [kg]\n10;400;1\n20;380;1\n", "utf-8", [0.01, 0.02], [0.4, 0.38],
     "F_t in g taken for weights, F_n in kg taken for weights"),
    ("Log 5\nTime (s),Vel (mm/s),Ff (N),Fz (N),Ff/Fz\n0,1,2,10,0.2\n1,2,3,10,0.3\n", "utf-8", [0.001, 0.002],
     [0.2, 0.3], "v in mm/s, mu from column 5"),
    ("v [m/s],F_t [N],F_n [N]\n" + "0.1,4,10\n0.1,-4,10\n" * 5, "utf-8", [0.1] * 10, [0.4] * 10,
     "both signs of F_t folded"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "encoding", "v", "mu", "words"), READ)
def test_files_of_instruments_are_understood(tmp_path, text, encoding, v, mu, words):
    """A preamble, both strokes, units in a row of their own, a header in a comment, encodings."""
    read = ss.read_measurements(write(tmp_path, text, encoding))
    assert (read.v.tolist(), read.mu.tolist()) == (v, mu)
    assert words in str(read)


def test_an_empty_column_is_one(tmp_path):
    """Tabs are never taken for blanks, which would move every column behind it."""
    text = "t\t\tv\tmu\tload\n1\t\t0.1\t0.42\t2.1\n2\t\t0.2\t0.36\t2.2\n3\t\t0.4\t0.29\t2.3\n"
    for file in (text, "Run 5 of 7\n" + text, text.replace("\t\t", "\t \t")):
        path = write(tmp_path, file)
        for columns in (None, {"v": "3 [m/s]", "mu": 4}, {"v": 3, "mu": "mu"}):
            read = ss.read_measurements(path, columns=columns)
            assert (read.v.tolist(), read.mu.tolist()) == ([0.1, 0.2, 0.4], [0.42, 0.36, 0.29])
    with pytest.raises(ss.InputError, match="column 2"):
        ss.read_measurements(path, columns={"v": "2 [m/s]", "mu": 4})


def test_a_deviation_behind_the_speed_is_that_of_the_speed(tmp_path):
    rows = "0.1,0.01,0.4,0.02\n0.2,0.01,0.3,0.03\n"
    for header, sigma in (
        ("v,std,mu,std", [0.02, 0.03]), ("v,std,mu,x", None), ("v,std(mu),mu,x", [0.01, 0.01]),
        ("v,x,mu,sigma", [0.02, 0.03]), ("v,uncertainty,mu,sd(mu)", [0.02, 0.03]),
    ):  # fmt: skip
        read = ss.read_measurements(write(tmp_path, f"{header}\n{rows}"))
        assert (None if read.sigma is None else read.sigma.tolist()) == sigma
        assert read.mu.tolist() == [0.4, 0.3]
        assert ("not read: std" in str(read)) == (header.split(",")[1] == "std")
    chosen = ss.read_measurements(write(tmp_path, f"v,std,mu,x\n{rows}"), columns={"sigma_mu": 2})
    assert chosen.sigma.tolist() == [0.01, 0.01]


def test_a_radius_that_may_be_in_millimetres_needs_its_unit(tmp_path):
    path = write(tmp_path, "rpm;mu\n60;0.4\n120;0.3\n")
    for radius in (25, "25", 1.5):
        with pytest.raises(ss.InputError, match=r"without a unit .*radius=\"[\d.]+ mm\" or radius=\"[\d.]+ m\""):
            ss.read_measurements(path, radius=radius)
    for radius, metres in (("25 mm", 0.025), ("25 m", 25), (0.025, 0.025), (1, 1)):
        read = ss.read_measurements(path, radius=radius)
        assert read.v == pytest.approx(np.array([1, 2]) * 2 * np.pi * metres, rel=1e-15)


def test_chosen_forces_win_over_a_coefficient(tmp_path):
    path = write(tmp_path, "v [m/s],Fx [N],Fz [N],X,COF,friction\n1,2,10,5,0.9,0.8\n2,3,10,5,0.9,0.8\n")
    assert ss.read_measurements(path).mu.tolist() == [0.9, 0.9]
    for columns in ({"F_t": 2, "F_n": 3}, {"F_t": "Fx"}):
        assert ss.read_measurements(path, columns=columns).mu.tolist() == [0.2, 0.3]
    assert ss.read_measurements(path, columns={"F_t": 2, "F_n": "4 [N]"}).mu.tolist() == [0.4, 0.6]
    assert ss.read_measurements(path, columns={"mu": 6}).mu.tolist() == [0.8, 0.8]
    with pytest.raises(ss.InputError, match=r"column 2, 'Fx .N.', is F_t too"):
        ss.read_measurements(path, columns={"F_n": 3})
    with pytest.raises(ss.InputError, match="mu and F_t are chosen"):
        ss.read_measurements(path, columns={"mu": 5, "F_t": 2})


STEP = [(80, 0.0926), (200, 0.0692), (320, 0.058)]
"""Sliding speeds in mm/s and coefficients of a step of a traction machine."""


def traction(copied=True, names="Ball Speed 1\tDisc Speed 1\tRolling Speed (mm/s)\tSliding Speed (mm/s)\tSRR (%)"):
    """A step in groups of columns that empty ones part; the first group repeats columns of the others."""
    first = "Step Time (s)\tTraction Coeff (-)\t\t\tStep Time (s)\tBall Load (N)"
    header = f"{first}\t\t{names}\t\tTraction Force (N)\tTraction Coeff (-)\t\tRC"
    rows = [
        f"{i}\t{mu}\t\t\t{i}\t20\t\t960\t1040\t1000\t{v}\t{v / 10}\t\t{20 * mu:.4f}\t{mu + (not copied)}\t\t"
        for i, (v, mu) in enumerate(STEP)
    ]
    return "\n".join(["Machine 9 Data File", "Number of steps:\t3", "", header, *rows])


def test_groups_of_columns_with_copies_and_many_speeds_are_read(tmp_path):
    """The one that is named a slip speed is the slip speed; a copy is no second coefficient."""
    path = write(tmp_path, traction())
    for columns in (None, {"mu": 15}, {"v": 11}, {"v": "Sliding Speed", "mu": "Traction Coeff (-)"}):
        read = ss.read_measurements(path, columns=columns)
        assert read.v == pytest.approx([v / 1000 for v, _ in STEP], rel=1e-15)
        assert read.mu.tolist() == [mu for _, mu in STEP]
    with pytest.raises(ss.InputError, match=r"column 15, 'Traction Coeff .-.': column 2, .* is mu too"):
        ss.read_measurements(write(tmp_path, traction(copied=False)))
    with pytest.raises(ss.InputError, match=r"beside .SRR .%.. this may be the mean speed"):
        ss.read_measurements(write(tmp_path, traction(names="A\tDisc Speed [mm/s]\tB\tC\tSRR (%)")))
    twice = ss.read_measurements(write(tmp_path, f"{traction()}\n\nStep 3\n{traction()}"))
    assert twice.mu.tolist() == sorted(2 * [mu for _, mu in STEP], reverse=True)


LOGGER = "Step, Time,DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),Rotary.Velocity (rpm),XYZ.X Position (mm),"


def test_a_logger_with_its_radius_above_the_table_is_read_after_one_hint(tmp_path):
    """Preamble lines parted by a bare carriage return, commas at the ends, no unit of the radius."""
    rows = "".join(f"4,{i}.100,4.99,1.2,{0.3 - 0.01 * i:.2f},{60 * i},0,\n" for i in (1, 2, 3))
    path = write(tmp_path, f"Recipe, Averaging, Radius\rspeeds,1000,12,\r\n{LOGGER}\r\n{rows}")
    with pytest.raises(ss.InputError, match=r'line 1 has .Radius. = 12; if .* in mm, radius="12 mm"'):
        ss.read_measurements(path)
    read = ss.read_measurements(path, radius="12 mm")
    assert read.v == pytest.approx(2 * np.pi * 0.012 * np.array([1, 2, 3]), rel=1e-15)
    assert read.mu.tolist() == [0.29, 0.28, 0.27]


@pytest.mark.parametrize(
    ("preamble", "metres"),
    [("Disc track radius used for this step (mm);21.000", 0.021), ("Track radius: 12 mm", 0.012),
     ("# wear track radius = 1.5 cm", 0.015), ("Date;Track radius [mm]\n3.4.;30", 0.03),
     ("Track radius;12;mm", 0.012), ("Track radius;1,5 cm", 0.015), ("Track radius;1,500 cm", None),
     ("Ball radius (mm);3", None), ("Radius (mm);3", None), ("Track radius;12", None),
     ("Track radius;12 mm\nTrack radius;13 mm", None)],
)  # fmt: skip
def test_the_radius_of_the_track_is_taken_where_it_is_certain(tmp_path, preamble, metres):
    path = write(tmp_path, f"{preamble}\nSpeed (rpm);COF\n60;0.4\n120;0.3\n")
    if metres is None:
        with pytest.raises(ss.InputError, match="give the radius of the track"):
            ss.read_measurements(path)
    else:
        read = ss.read_measurements(path)
        assert read.v == pytest.approx(2 * np.pi * metres * np.array([1, 2]), rel=1e-15)
        assert re.search(r"v in rpm, radius .* from line 1, mu from", str(read))
    assert ss.read_measurements(path, radius=1).v == pytest.approx(2 * np.pi * np.array([1, 2]), rel=1e-15)
    linear = write(tmp_path, f"{preamble}\nSpeed (m/s);COF\n60;0.4\n")
    assert ss.read_measurements(linear).v.tolist() == [60]


CELLS = [
    ("v [m/s],mu\n0.1,0.44(5)\n0.2,0.4(1)\n", [0.1, 0.2], [0.44, 0.4], [0.05, 0.1]),
    ("v [m/s];mu\n0,1;0,44 ± 0,05\n0,2;0,4 +/- 0,1\n", [0.1, 0.2], [0.44, 0.4], [0.05, 0.1]),
    ("v [m/s]  mu\n0.1  0.44 ± 0.05\n0.2  0.4 +/- 0.1\n", [0.1, 0.2], [0.44, 0.4], [0.05, 0.1]),
    ("V,mu\n10 mm/s,0.44\n20 mm/s,0.4\n", [0.01, 0.02], [0.44, 0.4], None),
    ("V (mm/s);mu\n10 mm/s;0,44(5)\n20mm/s;0,4(1)\n", [0.01, 0.02], [0.44, 0.4], [0.05, 0.1]),
    ("v [m/s]\tF_t\tF_n\n0.1(1)\t4.4(5) N\t0.01 kN\n0.2(1)\t4.0(10) N\t0.01 kN\n", [0.1, 0.2], [0.44, 0.4],
     [0.05, 0.1]),
    ("v [m/s],mu\n0.1,44 %\n0.2,40 %\n", [0.1, 0.2], [0.44, 0.4], None),
]  # fmt: skip


@pytest.mark.parametrize(("text", "v", "mu", "sigma"), CELLS)
def test_cells_with_standard_errors_and_units_are_read(tmp_path, text, v, mu, sigma):
    path = write(tmp_path, text)
    for columns in (None, {"v": 1}):
        read = ss.read_measurements(path, columns=columns)
        assert (read.v.tolist(), read.mu.tolist()) == (v, mu)
        assert (None if read.sigma is None else read.sigma.tolist()) == sigma


@pytest.mark.parametrize(
    "text",
    ["v [m/s],mu\n0.1,0.44(5)\n0.2,0.4\n", "v,mu\n0.1 m/s,0.44\n20 mm/s,0.4\n", "v [m/s],mu\n0.1 mm/s,0.4\n",
     "v [m/s],mu\n0.1,0.44(5)\n0.2,0.4(1),0.3\n", "v [m/s],mu\n0.1,0.44\n0.2,0.4(1)\n"],
)  # fmt: skip
def test_cells_that_are_written_in_two_ways_are_refused(tmp_path, text):
    with pytest.raises(ss.InputError, match=r"line [23], column|without a unit|line 3.* the row has 3 columns"):
        ss.read_measurements(write(tmp_path, text))


def test_columns_are_named_by_the_user(tmp_path):
    text = "Rotation [rpm]\tReading X\tTorque [Nm]\n100\t0.4\t1\n200\t0.35\t2\n300\t0.34\t3\n"
    path = write(tmp_path, text)
    both = {"v": 1, "mu": "Reading X"}
    read = ss.read_measurements(path, columns=both, radius="0.03")
    assert read.v == pytest.approx(np.array([100, 200, 300]) * 2 * np.pi / 60 * 0.03, rel=1e-15)
    assert read.mu.tolist() == [0.4, 0.35, 0.34]
    swapped = ss.read_measurements(path, columns={"v": "Torque [mm/s]", "mu": 2})
    assert swapped.v.tolist() == [0.001, 0.002, 0.003]
    unnamed = tmp_path / "unnamed.csv"
    unnamed.write_text("0.1 0.5 7\n0.2 0.4 7\n0.3 0.3 7\n")
    numbered = {"v": 1, "mu": 2}
    ranged = ss.read_measurements(unnamed, columns=numbered, speeds=(0.15, "0.3"))
    assert (ranged.mu.tolist(), "2 of 3 from 0.15 to 0.3 m/s" in str(ranged)) == ([0.4, 0.3], True)
    for file, change, message in (
        (
            path,
            {},
            r"line 1, column 1, 'Rotation .rpm.': .* give the radius .*, 'Torque .Nm.': .*; no column is F_n",
        ),
        (path, {"columns": both}, r"rpm is a rotational speed; give the radius.*radius=0.03"),
        (unnamed, {"columns": 3}, "columns is a dict like .*, got int: 3"),
        (unnamed, {"columns": {"x": 1}}, "a column holds v, mu"),
        (unnamed, {"columns": {"v": "Y", "mu": 2}}, "no columns are 'Y'; it has"),
        (unnamed, {"columns": numbered, "radius": 0.03}, "a speed already"),
        (unnamed, {"columns": numbered, "radius": -1}, "radius = -1 m is that of no track"),
        (unnamed, {"columns": numbered, "speeds": (1, 0.5)}, "are no range"),
        (unnamed, {"columns": numbered, "speeds": (7, 8)}, "no row from 7"),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.read_measurements(file, **change)


@pytest.mark.parametrize(("start", "kind"), [(b"PK\x03\x04", ".xlsx"), (b"\xd0\xcf\x11\xe0", ".xls")])
def test_a_workbook_is_named_as_one(tmp_path, start, kind):
    (tmp_path / "a.csv").write_bytes(start + bytes(40))
    with pytest.raises(ss.InputError, match=f"workbook .{kind}"):
        ss.read_measurements(tmp_path / "a.csv")


@pytest.mark.parametrize("swap", [("F_n [N]", "F_t [N]"), ("F_t [mN]", "F_t [N]"), ("v [m/s]", "v [mm/s]")])
def test_swapped_columns_and_units_are_noticed(swap, tmp_path):
    """The agreement above would be worth nothing if another header gave the same numbers."""
    one, other = swap
    header = "v [mm/s],F_t [N],F_n [N]"
    changed = header.replace(one, "X").replace(other, one).replace("X", other)
    row = "\n100,4,10\n"
    before, after = (ss.read_measurements(write(tmp_path, text + row)) for text in (header, changed))
    assert (before.v[0], before.mu[0]) != (after.v[0], after.mu[0])


def test_noise_about_zero_is_not_folded(tmp_path):
    """Magnitudes of noise have a mean above 0; of strokes, forth and back, they are the friction."""
    rng = np.random.default_rng(2)
    noisy = "".join(f"0.1,{-0.01 if i == 7 else 0.05 + 0.03 * rng.uniform(-1, 1):.4f},10\n" for i in range(30))
    read = ss.read_measurements(write(tmp_path, "v [m/s],F_t [N],F_n [N]\n" + noisy))
    assert read.mu.min() == -0.001


def test_repeated_speeds_are_averaged(tmp_path):
    rows = "0.2,0.3\n0,0.5\n0.1,0.42\n0.1,0.38\n0.4,0.25\n0.8,0.2\n0.8,0.23\n0.8,0.2\n"
    read = ss.read_measurements(write(tmp_path, "v,mu\n" + rows))
    means = read.averaged()
    assert (len(read), means.v.tolist()) == (8, [0, 0.1, 0.2, 0.4, 0.8])
    assert means.mu == pytest.approx([0.5, 0.4, 0.3, 0.25, 0.21], rel=1e-15)
    scatter = ((2 * 0.02**2 + 2 * 0.01**2 + 0.02**2) / 3) ** 0.5  # 8 rows less 5 means
    assert means.sigma == pytest.approx(scatter / np.sqrt([1, 2, 1, 1, 3]))
    assert "averaged at 5 speeds, scatter 0.022" in str(means)
    law = ss.FrictionLaw.from_csv(tmp_path / "pin.csv")  # decimal text stays exact
    at = [law.expr.subs(ss.symbols.v, place) for place in (0, law.kinks()[0], law.v_max)]
    assert (at, law.v_max) == ([Rational(1, 2), Rational(2, 5), Rational(21, 100)], Rational(4, 5))
    weighted = Measurements.of([1, 1, 2], [0.2, 0.5, 0.3], [0.1, 0.2, 0.1]).averaged()
    assert weighted.mu == pytest.approx([(0.2 * 100 + 0.5 * 25) / 125, 0.3])
    assert weighted.sigma == pytest.approx([125**-0.5, 0.1])


def test_thousands_of_rows_are_read_and_binned(tmp_path):
    rng = np.random.default_rng(4)
    v, mu = np.round(rng.uniform(0, 1, 8000), 5), np.round(rng.uniform(0.2, 0.4, 8000), 4)
    text = "v [mm/s],mu\n" + "".join(f"{1000 * speed:.2f},{value}\n" for speed, value in zip(v, mu, strict=True))
    read = ss.read_measurements(write(tmp_path, text))
    assert len(read) == 8000
    assert read.v == pytest.approx(np.sort(v), abs=1e-15)
    bins = read.binned(40)
    assert len(bins) == 40
    assert bins.v[0] == pytest.approx(np.sort(v)[:200].mean())
    assert bins.sigma == pytest.approx(0.2 / 12**0.5 / 200**0.5, rel=0.05)
    with pytest.raises(ss.InputError, match=r"fit a law to so many .*bins=60"):
        ss.FrictionLaw.from_csv(tmp_path / "pin.csv")
    np.testing.assert_array_equal(ss.read_measurements(tmp_path / "pin.csv", bins=40).mu, bins.mu)
    for count in (0, 8001):
        with pytest.raises(ss.InputError, match=f"{count} bins of 8000 rows; take 1 to 8000"):
            read.binned(count)


FORCES = "v [m/s],F_t [N],F_n [N]\n"
REFUSED = {
    "": "has no points; write a line for each",
    "v,mu\n": "has no points below line 1",
    "v [furlong/s],mu\n1,2\n": "line 1, column 1, 'v .furlong/s.': 'furlong/s' is no unit known here of",
    "v [N],mu\n1,2\n": "column 1.*'N' is no unit of a speed",
    "v,mu\n1,2\0\n": "is not a text file of columns: it holds null bytes",
    "V,mu\n1,2\n": r"column 1, 'V': a speed without a unit; write v \[m/s\]",
    "v,mu,COF\n1,2,3\n": "column 3, 'COF': column 2, 'mu', is mu too; give columns={'mu': 2} or columns={'mu': 3}",
    "Mean Speed [mm/s],SRR (%),mu\n1,50,2\n": "column 1, .*this may be the mean speed of two rolling.*={'v': 1}",
    "V1 [m/s],V2 [m/s],mu\n1,0.5,2\n": "column 2, 'V2 .m/s.': column 1, 'V1 .m/s.', is v too",
    "v [m/s],Fx [N],Fy [N],Fz [N]\n1,2,3,4\n": "column 2, 'Fx .N.', is F_t too; give columns={'F_t': 2} or",
    "v [m/s],mu,sd [%]\n1,2,3\n": "column 3, 'sd .%.': this may be in per cent of each mu, or of 1",
    "v,friction\n1,2\n": "column 2, 'friction': this may be mu or F_t; .*, read it by: read_measurements",
    FORCES.replace("\n", ",std\n") + "1,2,3,4\n": "'std': this may be sigma_mu or sigma_F_t",
    "v,F_t [N]\n1,2\n": "line 1: no column is F_n; understood: 'v' as v, 'F_t .N.' as F_t; .*, 'F_n': '10 N'}",
    "v,F_t [N],F_n [N],sigma_F_t\n1,2,3,4\n": "write those of all, like F_t .N., F_n .N., sigma_F_t .N.",
    "v,F_t [N],F_n [N],sigma_F_t [N],sigma_mu\n1,2,3,4,5\n": "sigma of mu and of F_t",
    "rpm,mu\n1,2\n": "rpm is a rotational speed; give the radius of the track in m, like radius=0.03",
    "v,mu\n350,0.4\n400,0.3\n": "line 2, column 1: got v = 350; without a unit a speed is in m/s; write it",
    "v,mu\n0.1,9\n": "line 2, column 2: a coefficient of friction is below 5; got mu = 9",
    "v [um/s];mu\n10,000;1\n20,000;1\n": "the comma in '10,000' may .* as all have three digits",
    "v [um/s]\tmu\n10,000\t0.4\n": "the comma in '10,000' may .* stand between thousands, as '0.4' has a point",
    "v [um/s];mu\n1.085,21;0,4\n": "line 2, column 1.*without a sign between thousands; got '1.085,21'",
    "Drive 7\nrun 4, ok\nt,omega,torque\n1,2,3\n2,3,4\n": "line 3: got 't,omega,torque'; a table begins",
    "0.1 0.5 7\n0.2 0.4 7\n": "line 1: got '0.1 0.5 7'; a table begins with a header",
    "v mu\n0.1 0.5 7\n": "line 1: 'v mu' names 2 columns, and line 2, '0.1 0.5 7', has not as many numbers",
    "v,mu\n" + "[" * 300_000: "line 2: it has 300000 characters; a row is a line of its own",
    "v,mu\n# note\n0,0.5\n1,0.4x\n": "line 4, column 2, 'mu': a finite number is needed.*got '0.4x'",
    "v,mu\n0,05,0,3\n": "line 2.*the row has 4 columns, and the header 2.*part the columns by semicolons",
    "v;mu\n0,5;0,4\n1;0.3\n": "the comma in '0,5' may be a decimal sign, .* as '0.3' has a point",
    'v,mu\n0,0.5\n1,"0.4\n2,0.3\n': "line 3, column 2, 'mu': a finite number is needed.*got '\"0.4'",
    "v,mu\n0,__import__('os')\n": "line 2, column 2, 'mu': a finite number is needed",
    "v,mu,sigma\n0,0.5,0.1\n1,0.4,0\n": "line 3, column 3: a standard deviation is above 0; got sigma_mu = 0",
    FORCES + "1,2,10\n2,3,0\n": "line 3, column 3: a normal force is not 0, and has one sign; got F_n = 0",
    FORCES + "1,2,10\n2,3,10\n3,3,-10\n": "line 4, column 3.*got F_n = -10",
    FORCES + "1,2,10\n-1,-2,10\n2,2,10\n-2,2,10\n": "line 5, column 2: F_t = 2 at v = -2 is along the motion",
}


@pytest.mark.parametrize("text", REFUSED)
def test_other_tables_are_refused_with_the_place(tmp_path, text):
    with pytest.raises(ss.InputError, match=REFUSED[text]):
        ss.read_measurements(write(tmp_path, text))
