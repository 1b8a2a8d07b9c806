"""Numbers with units, against the same numbers in SI units, wherever a number is read."""

import re
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from uncertainties import ufloat

import stickslip_sym as ss
from stickslip_sym.core.numbers import fraction, real
from stickslip_sym.core.uncertain import split
from support.commands import read_json

UNITS = {
    "V": {
        "mm/s": "0.001",
        "m/s": "1",
        "km/h": "5/18",
        "mm s^-1": "0.001",
        "m·s⁻¹": "1",
        "um/s": "1e-6",
        "MM/S": "0.001",
        "M/MIN": "1/60",
    },
    "N": {"kN": "1000", "N": "1", "mN": "0.001", "kg m/s^2": "1", "kg mm/s/s": "0.001"},
    "m": {"g": "0.001", "kg": "1", "t": "1000", "lbm": "0.45359237", "oz": "0.028349523125"},
    "k": {"N/mm": "1000", "kN/m": "1000", "N/m": "1", "kg/s^2": "1", "N mm⁻¹": "1000"},
    "c": {
        "kg/s": "1",
        "N s/m": "1",
        "N*s/mm": "1000",
        "g/s": "0.001",
        "Ns/m": "1",
        "N.s/m": "1",
        "N/(m/s)": "1",
        "kNs/m": "1000",
        "N/(mm/s)": "1000",
        "kg Hz": "1",
        "mNs/mm": "1",
    },
}
CASES = [(name, unit, size) for name, units in UNITS.items() for unit, size in units.items()]


@given(st.sampled_from(CASES), st.integers(1, 10**6), st.integers(0, 4), st.sampled_from(["", " "]))
def test_a_number_with_a_unit_is_the_number_in_si_units(case, digits, places, blank):
    """Exactly, and its standard error too, in either way of writing it."""
    name, unit, size = case
    value, error = Fraction(digits, 10**places), Fraction(7, 10**places)
    text = f"{digits / 10**places:.{places}f}"
    assert fraction(f"{text}{blank}{unit}", name) == value * Fraction(size)
    for written in (f"{text}(7)", f"{text}+/-{float(error):.{places}f}", f"({text} ± {float(error):.{places}f})"):
        read = split(f"{written}{blank}{unit}", name)[1]
        assert read.nominal_value == pytest.approx(float(value * Fraction(size)), rel=1e-15)
        assert read.std_dev == pytest.approx(float(error * Fraction(size)), rel=1e-14)


@pytest.mark.parametrize(("name", "unit", "size"), CASES)
def test_every_way_to_write_a_unit_is_read(name, unit, size):
    assert fraction(f"2 {unit}", name) == 2 * Fraction(size)


@pytest.mark.parametrize("name", UNITS)
def test_a_unit_of_the_wrong_kind_is_refused_with_the_right_one(name):
    right = {"V": "m/s", "N": "N", "m": "kg", "k": "N/m", "c": "kg/s"}[name]
    for kind, units in UNITS.items():
        for unit in units if kind != name else ():
            with pytest.raises(ss.InputError, match=f"has the unit .*, and {name} is in {right}; write"):
                fraction(f"2 {unit}", name)
    with pytest.raises(ss.InputError, match=r"has the unit .*, and"):
        fraction({"N": "2 m/s^2", "c": "2 1/s", "k": "2 s^-2"}.get(name, "2 1/s^2"), name)
    for text in ("2 furlong/s", "2 kg s", "x mm/s", "2e m"):
        with pytest.raises(ss.InputError, match=r"is not a number|has the unit"):
            fraction(text, name)


def test_units_are_read_wherever_numbers_are(run, tmp_path):
    point = {"V": "400 mm/s", "N": "0.02 kN", "m": "500 g", "k": "2 N/mm"}
    in_si = {"V": 0.4, "N": 20.0, "m": 0.5, "k": 2000.0}
    assert ss.Oscillator(**point) == ss.Oscillator(**in_si)
    law = ss.laws.stribeck.typical(v_s="30(2) mm/s", mu_s="50 %")
    assert (law.values["v_s"], law.values["mu_s"]) == (Fraction(3, 100), Fraction(1, 2))
    assert law.uncertain["v_s"].std_dev == 0.002
    for values, message in (({"v_s": "30 N"}, "v_s is in m/s"), ({"delta": "3 mm"}, "delta is a pure number")):
        with pytest.raises(ss.InputError, match=message):
            ss.laws.stribeck.bind(**values)
    assert ss.FrictionLaw("a - b*v").bind(b="2 s/km").values["b"] == Fraction(2, 1000)
    options = [word for name, text in point.items() for word in (f"-{name}", text)]
    parameter = ["-p", "mu_s=0.5", "-p", "alpha=3000 s/km"]
    code, out, err = run("damping", "exponential", *options, *parameter, "--method", "harmonic")
    assert (code, err) == (0, "")
    assert "V = 0.4 m/s, N = 20 N, m = 0.5 kg, k = 2000 N/m" in out
    toml = "".join(f'{name} = "{text}"\n' for name, text in point.items())
    (tmp_path / "a.toml").write_text(f'law = "exponential"\n{toml}[parameters]\nalpha = "3000 s/km"\nmu_s = 0.5\n')
    assert run("damping", "--point", "a.toml", "--method", "harmonic")[1] == out
    value = ss.pure_slip_damping(ss.laws.exponential.typical(), **point, method="harmonic").value
    assert value == ss.pure_slip_damping(ss.laws.exponential.typical(), **in_si, method="harmonic").value
    assert run("damping", "exponential", "-V", "400 N")[2].startswith(
        "error: V = '400 N' has the unit N, and V is in"
    )
    array = ss.pure_slip_damping(ss.laws.exponential.typical(), V=np.array([0.4]), N="0.02 kN", method="harmonic")
    assert array.value[0] == value


def test_ranges_and_axes_have_units(run):
    """A unit at the end is that of both ends; a quotient of units is exact."""
    law, at = ss.laws.exponential.typical(), {"N": 9.81, "m": 1, "k": 100}
    for range_of, si in (("100:2000 mm/s", (0.1, 2)), ("0.1:200 cm/s", (0.001, 2)), ("10 mm/s:2", (0.01, 2))):
        code, out, err = run("critical", "exponential", "--of", "V", "-c", "2", "--within", range_of, "--json")
        assert (code, err) == (0, "")
        (value,) = ss.critical(law, "V", **at, c=2, within=si)
        assert [one["value"] for one in read_json(out)["values"]] == [value.value]
    assert ss.critical(law, "V", **at, c=2, within=("3.6 kph", "10 km/h"), method="harmonic") == ()
    low, high = ss.critical(law, "alpha", **at, V=0.5, c=2, within=("500 s/km", "10"), method="harmonic")
    assert 0.5 < low.value < high.value < 10
    axes = ["--x", "V=100:500 mm/s:3", "--y", "alpha=3000 s/km:4:2"]
    code, out, err = run("map", "exponential", *axes, "-c", "2", "--json")
    found = read_json(out)
    assert (found["x"]["values"], found["y"]["values"]) == (np.linspace(0.1, 0.5, 3).tolist(), [3, 4])
    assert ss.motion_map(law, x=("V", ["100 mm/s", "0.5"]), y=("c", [1, 2]), **at).x.values.tolist() == [0.1, 0.5]
    for line in (["critical", "exponential", "--of", "V", "-c", "2", "--within", "1:2 N"],
                 ["map", "exponential", "--x", "V=1:2 kg:3", "--y", "c=1:2:2"]):  # fmt: skip
        code, out, err = run(*line)
        assert (code, out) == (2, "")
        assert "and V is in m/s; write it so" in err


class Quantity:
    """A number, or an array, with a unit, as pint has it or as astropy has it: the library converts it."""

    SIZES = {"mm/s": ("m/s", 1e-3), "m/s": ("m/s", 1.0), "kN": ("N", 1e3), "g": ("kg", 1e-3)}  # noqa: RUF012

    def __init__(self, value, unit, of_pint):
        self.value, self.name, self.of_pint = value, unit, of_pint
        setattr(self, "units" if of_pint else "unit", SimpleNamespace(__str__=lambda _: unit))
        if of_pint:
            self.magnitude = value

    def to(self, unit):
        own, size = self.SIZES[self.name]
        if own != unit:
            raise ValueError(f"cannot convert from {own} to {unit}")
        return Quantity(self.value * size, unit, self.of_pint) if unit in self.SIZES else _Bare(self.value * size)


class _Bare:
    def __init__(self, value):
        self.magnitude = self.value = value


@pytest.mark.parametrize("of_pint", [True, False])
def test_quantities_of_other_libraries_are_converted_by_them(of_pint):
    """To drop the unit would change the number by 1000 in silence."""

    def quantity(value, unit):
        return Quantity(value, unit, of_pint)

    law = ss.laws.exponential.typical()
    form = ss.derive(law)
    expected = form(V=0.5, N=9.81)
    assert form(V=quantity(500.0, "mm/s"), N=quantity(9.81e-3, "kN")) == pytest.approx(expected, rel=1e-14)
    assert form(V="500 mm/s", N=9.81) == expected
    assert form(V=[quantity(500.0, "mm/s"), quantity(0.5, "m/s")], N=9.81) == pytest.approx(expected)
    assert form(V=quantity(np.array([500.0]), "mm/s"), N=9.81) == pytest.approx(expected)
    assert law.mu(quantity(500.0, "mm/s")) == pytest.approx(law.mu(0.5), rel=1e-15)
    osc = ss.Oscillator(m=quantity(1000.0, "g"), k=100, V=quantity(500.0, "mm/s"), N=9.81)
    assert (osc.m, osc.V) == (1.0, 0.5)
    with pytest.raises(ss.InputError, match="V carries the unit"):
        ss.Oscillator(m=1, k=100, V=quantity(5.0, "g"), N=9.81)
    with pytest.raises(ss.InputError, match="no unit is known here"):
        ss.derive("exponential")(V=0.5, N=9.81, mu_s=quantity(0.5, "m/s"), mu_m=0.2, alpha=3)


@pytest.mark.parametrize(
    "text", ["1/2(1) m/s", "1/0 m/s", "1/2+/-1/0 m/s", "1/2/3 m/s", "1..5 m/s", "0.5.(1) m/s"]
)
def test_what_is_no_number_before_a_unit_is_refused(text):
    for read in (fraction, split):
        with pytest.raises(ss.InputError, match=r"^V = .* is not a number"):
            fraction(read(text, "V")[0], "V") if read is split else read(text, "V")


@pytest.mark.parametrize("value", ["0.400(5)", "0.400+/-0.005", "40(5) cm/s", "(0.4 ± 0.1)", ufloat(0.4, 0.005)])
def test_a_standard_error_that_is_not_used_is_named(value):
    with pytest.raises(ss.InputError, match=r"V = .* has a standard error, and none is used here; give"):
        real("V", value)
    with pytest.raises(
        ss.InputError, match=r"V = .* an Oscillator holds numbers alone; .*errors=.*pure_slip_damping"
    ):
        ss.Oscillator(V=value, N=9.81, m=1, k=100)
    if "cm" not in str(value):  # the way that is named, for a force
        needed = ss.pure_slip_damping(ss.laws.linear.typical(), V=0.5, N=value)
        assert needed.budget.uncertainty / needed.value == pytest.approx(0.0125 if "1" not in str(value) else 0.25)


@pytest.mark.parametrize("unit", ["rev/min", "furlong/s", "N/(m", "Nss/m", "mm/S"])
def test_a_unit_that_is_not_known_is_named(unit):
    with pytest.raises(ss.InputError, match=re.escape(f"has the unit {unit!r}, which is not known here")):
        fraction(f"2 {unit}", "V")


def test_quotients_with_units_are_exact():
    assert fraction("1.5/2 m/s", "V") == Fraction(3, 4)
    assert fraction("1e3/3 mm/s", "V") == Fraction(1, 3)
