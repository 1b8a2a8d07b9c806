"""Files of measurements as instruments write them: read to the same numbers, or refused with line and column."""

from fractions import Fraction

import numpy as np
import pytest
from sympy import Rational

import stickslip_sym as ss

SPEED_UNITS = {"m/s": 1, "mm/s": 1000, "cm/s": 100, "um/s": 10**6, "m/min": 60, "km/h": Fraction(18, 5),
               "in/s": 1 / Fraction("0.0254"), "mm s^-1": 1000, "m·s⁻¹": 1, "mm/min": 60000, "nm/s": 10**9,
               "µm/s": 10**6}  # fmt: skip
FORCE_UNITS = {"N": 1, "kN": Fraction(1, 1000), "mN": 1000, "uN": 10**6, "daN": Fraction(1, 10)}
SPEED_WORDS = [
    "v",
    "speed",
    "Velocity",
    "sliding speed",
    "v_r",
    "V_rel",
    "slip velocity",
    "v_slip",
    "Sliding_Speed",
]
WORDS = {
    "mu": ["mu", "COF", "friction coefficient", "Coefficient of Friction", "μ", "µ"],
    "F_t": ["F_t", "Friction force", "Fx", "tangential force", "F_f"],
    "F_n": ["F_n", "Normal Force", "Fz", "normal load", "Load"],
    "sigma": ["sigma_mu", "std(mu)", "s_mu", "σ", "std", "uncertainty", "standard deviation"],
    "other": ["time [s]", "temperature (degC)", "Cycle", "humidity in %"],
}
DIALECTS = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("|", ","), (" ", "."), (" ", ",")]
FRAMES = ["{} [{}]", "{} ({})", "{} in {}", "{} / {}", "{}[{}]", '"{}, {}"', "{}_{}"]
UMT = """Instrument;pin on disc\r
# 12.03.2021, disc 7\r
t;Fx;Fz;Speed\r
s;N;N;mm/s\r
0,1;3,5;-10,0;100\r
0,2;-4,0;-10,0;-50,0\r
0,3;2,5;-10,0;250\r
"""


def write(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "pin.csv"
    path.write_bytes(text.encode(encoding))
    return path


def decimal(number, sign):
    """A number of at most 12 digits as text, in one of the usual ways."""
    exact = Fraction(number)
    text = f"{float(exact):.12g}"
    assert Fraction(text) == exact
    return text.replace(".", sign)


def in_unit(value, size):
    """A value times the size, to so few digits that it is exact as text, and what it then is in SI units."""
    text = f"{float(Fraction(value) * size):.6g}"
    return text, Fraction(text) / size


def random_table(rng):
    """A table in a random dialect, with the numbers that it means."""
    count = int(rng.integers(4, 12))
    forces, with_sigma, both = rng.random() < 0.5, rng.random() < 0.4, rng.random() < 0.4
    separator, sign = DIALECTS[rng.integers(len(DIALECTS))]
    unit = str(rng.choice(list(SPEED_UNITS)))
    directions = rng.choice([-1, 1], count) if both else np.ones(count, dtype=int)
    loads = np.round(rng.uniform(5, 50, count), 2)
    orientation = int(rng.choice([-1, 1])) if forces else 1
    columns = {"v": [], "sigma": [], "mu": [], "F_t": [], "F_n": []}
    meant = []
    f_unit, n_unit = (str(name) for name in rng.choice(list(FORCE_UNITS), 2))
    for direction, load in zip(directions.tolist(), loads, strict=True):
        v_text, v = in_unit(round(float(rng.uniform(0.001, 2)), 4), SPEED_UNITS[unit])
        mu_text, mu = in_unit(round(float(rng.uniform(0.1, 0.6)), 4), 1)
        sigma_text, sigma = in_unit(round(float(rng.uniform(0.001, 0.1)), 4), 1)
        f_text, f = in_unit(mu * Fraction(load), FORCE_UNITS[f_unit])
        n_text, n = in_unit(Fraction(load), FORCE_UNITS[n_unit])
        turn = "-" if direction * orientation < 0 else ""
        columns["v"].append(("-" if direction < 0 else "") + v_text)
        columns["mu"].append(("-" if direction < 0 else "") + mu_text)
        columns["sigma"].append(sigma_text)
        columns["F_t"].append(turn + f_text)
        columns["F_n"].append(n_text)
        meant.append((v, f / n if forces else mu, sigma))
    names = ["v", *(["F_t", "F_n"] if forces else ["mu"]), *(["sigma"] if with_sigma else [])]
    blanks = separator == " "

    def word(kind):
        words = SPEED_WORDS if kind == "v" else WORDS[kind]
        return str(rng.choice([one for one in words if not blanks or " " not in one]))

    frame = str(rng.choice([one for one in FRAMES if not blanks or one[2:4] in ("[{", " [", " (", "_{")]))
    if "_" in frame[2:] and any(mark in unit for mark in " ^·"):
        frame = FRAMES[0]
    units = {"v": unit, "F_t": f_unit, "F_n": n_unit}
    header = {
        name: frame.format(word(name), units[name]).strip('"') if name in units else word(name) for name in names
    }
    if forces and with_sigma:
        header["sigma"] = "sigma_mu"
    if rng.random() < 0.4:
        other = word("other") if not blanks else "time [s]"
        names, header[other] = [*names, other], other
        columns[other] = [f"{i}" for i in range(count)]
    rng.shuffle(names)
    quoted = [f'"{header[name]}"' if separator in header[name] else header[name] for name in names]

    def between():
        return separator * int(rng.integers(1, 4)) if blanks else separator

    rows = [
        between().join(columns[name][i].replace(".", sign) for name in names) + separator * int(rng.random() < 0.1)
        for i in range(count)
    ]
    lines = [*(["# made by a machine, 3;4,5"] if rng.random() < 0.5 else []), separator.join(quoted), *rows]
    if rng.random() < 0.5:
        lines.insert(int(rng.integers(1, len(lines) + 1)), "% a remark" if rng.random() < 0.5 else "")
    end = str(rng.choice(["\n", "\r\n"]))
    return end.join(lines) + end, meant, with_sigma, unit, forces


def test_random_tables_in_random_dialects_are_read_to_the_same_numbers(tmp_path):
    rng = np.random.default_rng(1699)
    for _ in range(250):
        text, meant, with_sigma, unit, forces = random_table(rng)
        encoding = str(rng.choice(["utf-8", "utf-8-sig", "utf-16"]))
        read = ss.read_measurements(write(tmp_path, text, encoding))
        order = sorted(range(len(meant)), key=lambda i: meant[i][0])
        for got, place in ((read.v, 0), (read.mu, 1), *([(read.sigma, 2)] if with_sigma else [])):
            np.testing.assert_array_equal(got, [float(meant[i][place]) for i in order], err_msg=text)
        assert with_sigma == (read.sigma is not None)
        assert f"v in {unit}," in f"{read},"
        assert ("mu from F_t/F_n" in str(read)) == forces


@pytest.mark.parametrize(
    "swap", [("mu", "v [mm/s]"), ("F_n [N]", "F_t [N]"), ("F_t [mN]", "F_t [N]"), ("v [m/s]", "v [mm/s]")]
)
def test_swapped_columns_and_units_are_noticed(swap, tmp_path):
    """The agreement above would be worth nothing if another header gave the same numbers."""
    one, other = swap
    header = "v [mm/s],mu" if "mu" in swap else "v [mm/s],F_t [N],F_n [N]"
    changed = header.replace(one, "X").replace(other, one).replace("X", other)
    row = {2: "\n100,0.5\n", 3: "\n100,4,10\n"}[header.count(",") + 1]
    before, after = (ss.read_measurements(write(tmp_path, text + row)) for text in (header, changed))
    assert (before.v[0], before.mu[0]) != (after.v[0], after.mu[0])


def test_an_instrument_with_a_preamble_units_below_and_both_signs(tmp_path):
    read = ss.read_measurements(write(tmp_path, UMT))
    assert read.v.tolist() == [0.05, 0.1, 0.25]
    assert read.mu.tolist() == [0.4, 0.35, 0.25]
    assert str(read) == "3 rows, v in mm/s, mu from F_t/F_n, both signs of speed folded, left out: t [s]"


def test_forces_of_both_strokes_are_folded_and_noise_about_zero_is_not(tmp_path):
    """Magnitudes of noise have a mean above 0; of strokes, forth and back, they are the friction."""
    strokes = "".join(f"0.1,{(-1) ** i * 4},10\n" for i in range(10))
    read = ss.read_measurements(write(tmp_path, "v [m/s],F_t [N],F_n [N]\n" + strokes))
    assert read.mu.tolist() == [0.4] * 10
    assert "both signs of F_t folded" in str(read)
    noisy = "".join(f"0.1,{-0.01 if i == 7 else 0.05},10\n" for i in range(30))
    read = ss.read_measurements(write(tmp_path, "v [m/s],F_t [N],F_n [N]\n" + noisy))
    assert read.mu.min() == -0.001


def test_repeated_speeds_are_kept_for_a_fit_and_averaged_for_a_curve(tmp_path):
    rows = "0.2,0.3\n0,0.5\n0.1,0.42\n0.1,0.38\n0.4,0.25\n0.8,0.2\n0.8,0.23\n0.8,0.2\n"
    read = ss.read_measurements(write(tmp_path, "v,mu\n" + rows))
    assert len(read) == 8
    means = read.averaged()
    assert means.v.tolist() == [0, 0.1, 0.2, 0.4, 0.8]
    assert means.mu == pytest.approx([0.5, 0.4, 0.3, 0.25, 0.21], rel=1e-15)
    scatter = ((2 * 0.02**2 + 2 * 0.01**2 + 0.02**2) / 3) ** 0.5  # 8 rows less 5 means
    assert means.sigma == pytest.approx(scatter / np.sqrt([1, 2, 1, 1, 3]))
    assert "averaged at 5 speeds, scatter 0.022" in str(means)
    law = ss.FrictionLaw.from_csv(tmp_path / "pin.csv")
    assert [law.expr.subs(ss.symbols.v, place) for place in (0, law.kinks()[0])] == [
        Rational(1, 2),
        Rational(2, 5),
    ]
    assert law.v_max == Rational(4, 5)  # decimal text stays exact


def test_a_mean_is_weighted_where_sigma_is_known():
    means = ss.Measurements.of([1, 1, 2], [0.2, 0.5, 0.3], [0.1, 0.2, 0.1]).averaged()
    assert means.mu == pytest.approx([(0.2 * 100 + 0.5 * 25) / 125, 0.3])
    assert means.sigma == pytest.approx([125**-0.5, 0.1])


def test_thousands_of_rows_are_read_and_binned(tmp_path):
    rng = np.random.default_rng(4)
    v, mu = np.round(rng.uniform(0, 1, 20_000), 5), np.round(rng.uniform(0.2, 0.4, 20_000), 4)
    text = "v [mm/s],mu\n" + "".join(f"{1000 * speed:.2f},{value}\n" for speed, value in zip(v, mu, strict=True))
    read = ss.read_measurements(write(tmp_path, text))
    assert len(read) == 20_000
    assert read.v == pytest.approx(np.sort(v), abs=1e-15)
    bins = read.binned(40)
    assert len(bins) == 40
    assert bins.v[0] == pytest.approx(np.sort(v)[:500].mean())
    assert bins.sigma == pytest.approx(0.2 / 12**0.5 / 500**0.5, rel=0.05)
    with pytest.raises(ss.InputError, match=r"fit a law to so many .*binned\(60\)"):
        ss.FrictionLaw.from_csv(tmp_path / "pin.csv")
    with pytest.raises(ss.InputError, match="0 bins of 20000 rows; take 1 to 20000"):
        read.binned(0)


FORCES = "v [m/s],F_t [N],F_n [N]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no points; write a line for each"),
        ("v,mu\n", "has no points below line 1"),
        ("v [furlong/s],mu\n1,2\n", r"line 1, column 1, 'v \[furlong/s\]': the unit 'furlong/s' is not known"),
        ("v [M/S],mu\n1,2\n", "the unit 'M/S' is not known"),
        ("v [N],mu\n1,2\n", "column 1.*'N' is no unit of a speed"),
        ("v,mu [%]\n1,2\n", "column 2.*the unit '%' is not known here; write one of a pure number"),
        ("V,mu\n1,2\n", r"column 1, 'V': a speed without a unit; write v \[m/s\]"),
        ("speed,mu\n1,2\n", "'speed': a speed without a unit"),
        ("v,mu,COF\n1,2,3\n", "line 1, column 3, 'COF': column 2, 'mu', is mu too"),
        ("v,friction\n1,2\n", "column 2, 'friction': this may be mu or F_t; write which"),
        (FORCES.replace("\n", ",std\n") + "1,2,3,4\n", "'std': this may be sigma_mu or sigma_F_t"),
        ("v,F_t [N]\n1,2\n", "line 1: no column is F_n; it has 'v', 'F_t"),
        ("v,F_t,F_n [N]\n1,2,3\n", "one force has a unit and the other"),
        ("rpm,mu\n1,2\n", "line 1: got 'rpm,mu', 2 columns, parted by commas; a table begins with a header"),
        ("time,force\n1,2\n", "line 1: got 'time,force'"),
        ("0,1,2\n1,2,3\n", "line 1: got '0,1,2', 3 columns"),
        ("nan,0.5\n1,0.4\n", "line 1: got 'nan,0.5'"),
        ("0.1 0.5 7\n0.2 0.4 7\n", "line 1: got '0.1 0.5 7', 3 columns, parted by blanks"),
        ("v\n0.1\n0.2\n", "line 1: got 'v', 1 column; a table begins"),
        ("v mu\n0.1 0.5 7\n", "line 2.*the row has 3 columns, and the header 2"),
        ("v,mu\n" + "[" * 300_000, "line 2: it has 300000 characters; a row is a line of its own"),
        ("v,mu\n# note\n0,0.5\n1,0.4x\n", "line 4, column 2, 'mu': a finite number is needed.*got '0.4x'"),
        ("v,mu\n0,0.5\n1,nan\n", "line 3, column 2, 'mu': a finite number"),
        ("v,mu\n0,0.5\n1,\n", "line 3, column 2, 'mu': a finite number is needed, like 0.35; got ''"),
        ("v,mu,t\n0,0.5,1\n1\n", "line 3, column 2, 'mu': the row has 1 column, and"),
        ("v,mu\n0,05,0,3\n", "line 2.*the row has 4 columns, and the header 2.*part the columns by semicolons"),
        (
            "v;mu\n0,5;0,4\n1;0.3\n",
            "'0.3' in line 3, column 2, has a decimal point, and '0,5' in line 2, column 1",
        ),
        ("v;mu\n1.000,5;0,4\n", "line 2, column 1, 'v': a finite number"),
        ('v,mu\n0,0.5\n1,"0.4\n2,0.3\n', "line 3: a quotation mark is not closed"),
        ("v,mu\n0,__import__('os')\n", "line 2, column 2, 'mu': a finite number is needed"),
        ("v,mu\n0,1_0\n", "a finite number is needed, like 0.35; got '1_0'"),
        ("v,mu,sigma\n0,0.5,0.1\n1,0.4,0\n", "line 3, column 3: sigma_mu = 0; a standard deviation is above 0"),
        (FORCES + "1,2,10\n2,3,0\n", "line 3, column 3: F_n = 0; a normal force is not 0"),
        (FORCES + "1,2,10\n2,3,10\n3,3,-10\n", "line 4, column 3: F_n = -10"),
        (
            FORCES + "1,2,10\n-1,-2,10\n2,2,10\n-2,2,10\n",
            r"line 5, column 2: F_t = 2 at v = -2 is along the motion",
        ),
        (FORCES + "0.1,2,9\n\n0.2,oops,9\n", r"line 4, column 2, 'F_t \[N\]': a finite number is needed"),
    ],
)
def test_what_is_not_understood_is_refused_with_its_place(tmp_path, text, message):
    with pytest.raises(ss.InputError, match=message):
        ss.read_measurements(write(tmp_path, text))


def test_older_encodings_are_read(tmp_path):
    read = ss.read_measurements(write(tmp_path, "v [µm/s];µ\n5;0,25\n", "cp1252"))
    assert (read.v[0], read.mu[0]) == (5e-6, 0.25)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1, 2], [1]), r"v has the shape \(2,\) and mu \(1,\)"),
        (([-1, 2], [1, 1]), "v = -1 is below 0"),
        (([1, 2], [1, 1], [0.1, 0]), "sigma = 0 is not above 0"),
        (([1, 2], [1, 1], [0.1]), r"sigma has the shape \(1,\)"),
        (([1, float("nan")], [1, 1]), "not finite"),
    ],
)
def test_arrays_that_are_no_measurements_are_refused(arguments, message):
    with pytest.raises(ss.InputError, match=message):
        ss.Measurements.of(*arguments)
