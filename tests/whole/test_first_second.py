"""What a first answer imports: numbers of the catalogue's laws take no SymPy, and a typo takes no NumPy either."""

import json
import subprocess
import sys

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.core.numbers import exact, fraction
from stickslip_sym.model.expression import parsing, spelling
from stickslip_sym.model.expression.units import check_unit, parse_unit
from stickslip_sym.motion.orbits import transforms

SCENE = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
COMMAND = (
    "import sys, stickslip_sym.cli.program as p\nsys.argv[1:] = {}\ntry: p.main()\nfinally: print(*sys.modules)"
)


def run(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    return done.stdout.splitlines(), done.stderr


def test_a_threshold_of_the_catalogue_takes_no_algebra():
    line = ["damping", "exponential", "-V", "0.5", "-N", "9.81", "-m", "1", "-k", "100"]
    (said, loaded), _ = run(COMMAND.format(line))
    assert said == str(ss.pure_slip_damping(ss.laws.exponential.typical(), **SCENE))
    assert not {"sympy", "scipy", "mpmath", "flint", "pydantic"} & set(loaded.split())


@pytest.mark.parametrize("command", ["damping", "derive", "simulate"])
def test_a_typo_takes_no_numbers(command):
    (loaded,), said = run(COMMAND.format([command, "exponentail", "-V", "0.5"]))
    assert "did you mean 'exponential'?" in said
    assert not {"sympy", "scipy", "numpy", "mpmath", "flint", "pydantic"} & set(loaded.split())


def test_a_new_law_is_proved_without_arrays():
    said, _ = run(COMMAND.format(["derive", "mu_m + (mu_s - mu_m)/(1 + v/v_s)", "--unit", "v_s=m/s"]))
    assert any(line.endswith("least_squares, PROVED") for line in said)
    assert {"sympy"} == {"sympy", "numpy", "scipy", "pydantic", "rich"} & set(said[-1].split())


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["damping", "exponential", "-V", "0.5", "-N", "1", "--rtol", "ab"], "--rtol"),
        (["derive", "exponential", "--time-limit", "1e"], "--time-limit"),
        (["derive", "exponential", "-p", "alpha"], "NAME=VALUE"),
        (["derive", "exponential", "-p", "alpha=1", "-p", "alpha=2"], "given twice"),
    ],
)
def test_what_is_no_text_is_still_read(line, said):
    _, error = run(COMMAND.format(line))
    assert said in error
    assert len(error.splitlines()) == 1


def test_thresholds_without_algebra_are_those_with_it():
    """Of laws that are read from the same formulas, whose functions SymPy makes."""
    code = (
        "import json, sys, stickslip_sym as ss\n"
        f"scene = {SCENE}\n"
        "names = ('exponential', 'polynomial', 'lorentzian_viscous', 'tanh')\n"
        "found = {n: ss.pure_slip_damping(ss.laws.catalogue[n].typical(), **scene).value for n in names}\n"
        "print(json.dumps(found))\nprint('sympy' in sys.modules)"
    )
    (found, algebra), _ = run(code)
    assert algebra == "False"
    for name, value in json.loads(found).items():
        law = ss.laws.catalogue[name]
        read = ss.FrictionLaw(law.text, parameters=law.parameters.values()).typical()
        assert value == pytest.approx(ss.pure_slip_damping(read, **SCENE).value, rel=1e-14), name


def test_units_that_need_no_algebra_are_units():
    rng = np.random.default_rng(5)

    def power():
        return rng.choice(["m", "s", "kg", "N"]) + rng.choice(["", "^2", "^3"])

    for _ in range(40):
        text = power() + "".join(rng.choice(["*", "/"]) + power() for _ in range(rng.integers(3)))
        for unit in (text, f"1/{text}"):
            check_unit(unit)
            parse_unit(unit)
    for wrong in ("Hz", "m+s", "m^", "2*m", "m s", "sin(m)", "m/", "", "m^v", "1/1"):
        refused = []
        for check in (check_unit, parse_unit):
            try:
                check(wrong)
            except ss.InputError as error:
                refused.append(str(error))
        assert len(refused) in (0, 2), wrong


def test_names_of_functions_are_known_without_them():
    read = {*parsing.FUNCTIONS, *parsing.KINKED, *parsing.CONSTANTS, "Piecewise"}
    assert read | {*spelling.ALIASES, *spelling.INSTEAD} == spelling.TAKEN


def test_fractions_are_exact_numbers():
    from decimal import Decimal
    from fractions import Fraction

    import mpmath
    import sympy as sp

    rng = np.random.default_rng(8)
    for x in (rng.normal(size=20) * 10.0 ** rng.integers(-300, 300, 20)).tolist():
        kinds = [
            x,
            repr(x),
            np.float64(x),
            Decimal(x),
            Fraction(x),
            mpmath.mpf(x),
            sp.Float(x, 60),
            sp.Rational(x),
        ]
        for number in kinds:
            got = fraction(number, "x")
            assert float(got) == x
            assert exact(number, "x") == sp.Rational(got.numerator, got.denominator)
    assert fraction("5.", "x") == 5
    assert fraction(" -.5e1/3 ", "x") == Fraction(-5, 3)
    for wrong in (True, float("nan"), -np.inf, Decimal("inf"), mpmath.inf, sp.pi, sp.oo, "0x1", "1/0", None, [1]):
        with pytest.raises(ss.InputError):
            fraction(wrong, "x")


@pytest.mark.parametrize("size", [16, 31, 64])
def test_sums_of_sines_and_cosines(size):
    """By their definition: SciPy's are not used any more."""
    rng = np.random.default_rng(size)
    coefficients, n = rng.normal(size=(3, size)), np.arange(size)
    phases = np.outer(n, (np.arange(size) + 0.5) * np.pi / size)
    for wave, forth, back in (
        (np.cos, transforms.from_cosines, transforms.cosines),
        (np.sin, transforms.from_sines, transforms.sines),
    ):
        values = coefficients @ wave(phases)
        assert np.abs(forth(coefficients) - values).max() < 1e-13 * size
        known = coefficients * (n > 0) if wave is np.sin else coefficients
        assert np.abs(back(values) - known).max() < 1e-14 * size


def test_weights_are_made_when_asked_for():
    import sympy as sp

    s = ss.symbols.s
    mine = ss.Criterion("least_squares", sp.Rational(5, 8) * (1 - s**4), ss.criteria.least_squares.source)
    assert mine == ss.criteria.least_squares
    assert hash(mine) == hash(ss.criteria.least_squares)
    assert mine != ss.Criterion("least_squares", sp.Rational(3, 4) * (1 - s**2), mine.source)
    assert mine != ss.criteria.harmonic
    assert ss.Criterion("late", lambda: sp.Rational(1, 2)).weight == sp.Rational(1, 2)
    assert ss.Criterion("late", lambda: sp.Rational(1, 2)).is_average
    assert not ss.criteria.equilibrium.is_average
    with pytest.raises(ss.InputError, match="integrates to 2"):
        _ = ss.Criterion("late", lambda: sp.Integer(1)).weight
    with pytest.raises(AttributeError):
        _ = mine.nonsense
