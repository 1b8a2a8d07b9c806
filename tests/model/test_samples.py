"""Laws through measured points: the curve, its criteria, and every refusal."""

import re
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.model.samples import MOST
from support.platforms import FOLDER_OPENED
from support.sweeps import fewer, some, sweep

SPEEDS = ["0", "0.05", "0.1", "0.2", "0.4", "0.7", "1.2"]
COEFFICIENTS = ["0.5", "0.44", "0.4", "0.34", "0.29", "0.27", "0.28"]


@pytest.fixture(scope="module")
def law():
    return ss.FrictionLaw.from_samples(SPEEDS, COEFFICIENTS)


@pytest.fixture(scope="module")
def form(law):
    return ss.derive(law)


STEPS = st.tuples(st.integers(1, 400), st.integers(-300, 900))
ROUNDING = 5e-12  # of speeds up to 5 m/s, times the slope of the steepest curve


@fewer(3)
@given(st.lists(STEPS, min_size=4, max_size=12), st.integers(0, 9))
@mpmath.workdps(30)
def test_a_curve_goes_through_its_points_and_falls_where_they_do(points, tenths):
    """Its slope is continuous, and every library computes its formula."""
    speeds = [sp.Rational(sum(gap for gap, _ in points[:i]), 1000) for i in range(len(points))]
    coefficients = [sp.Rational(mu, 1000) for _, mu in points]
    law = ss.FrictionLaw.from_samples(speeds, coefficients)
    assert law.mu(list(map(float, speeds))) == pytest.approx(list(map(float, coefficients)), abs=ROUNDING)
    for (low, high), (before, after) in zip(pairwise(speeds), pairwise(coefficients), strict=True):
        steps = np.diff(law.mu(np.linspace(float(low), float(high), 30)))
        assert (steps * np.sign(float(after - before)) >= -ROUNDING).all()
        assert before != after or np.abs(steps).max() < ROUNDING
    slope = law.function("mpmath", derivative=True)
    with mpmath.workdps(40):
        for place in map(to_mpf, law.kinks()):
            assert abs(slope(place) - slope(place - mpmath.mpf("1e-30"))) < 1e-20
    v = sp.Rational(tenths, 10) * speeds[-1]
    for derivative, formula in ((False, law.expr), (True, law.slope_expr)):
        expected = float(formula.subs(ss.symbols.v, v))
        for backend, number in (("numpy", np.float64(v)), ("math", float(v)), ("mpmath", to_mpf(v))):
            got = float(law.function(backend, derivative=derivative)(number))
            assert got == pytest.approx(expected, rel=1e-9, abs=1000 * ROUNDING if derivative else ROUNDING)


@sweep("criterion", ["equilibrium", "least_squares", "harmonic"], "least_squares")
def test_its_criteria_are_exact_closed_forms(law, form, criterion):
    form = form if criterion == form.criterion.name else ss.derive(law, criterion)
    assert form.verdict.status is (ss.Status.CHECKED if criterion == "harmonic" else ss.Status.PROVED)
    for V in ("0.01", "0.13", "0.6"):  # within the first piece, across some, across all
        exact = form.evaluate(40, V=V, N="9.81")
        with mpmath.workdps(40):
            middle = ss.enclose(law, criterion, V=V, N="9.81", digits=40).mid
            expected = [mpmath.mpf(middle.numerator) / middle.denominator]
            if V in some(["0.13"], 0):  # by quadrature too, which takes longer
                expected.append(ss.quadrature.damping(law, criterion, V=V, N="9.81", digits=40))
            for one in expected:
                assert abs(exact - one) <= abs(one) * mpmath.mpf(10) ** -37
        assert form(V=float(V), N=9.81) == pytest.approx(float(exact), rel=1e-12)


def test_a_wrong_curve_has_another_criterion(law):
    """The agreement above would be worth nothing if a thousandth in one point did not show."""
    changed = ss.FrictionLaw.from_samples(SPEEDS, [*COEFFICIENTS[:3], "0.341", *COEFFICIENTS[4:]])
    right, wrong = (float(ss.quadrature.damping(one, V="0.3", N=1, digits=15)) for one in (law, changed))
    assert abs(right - wrong) > 1e-5 * abs(right)


def test_speeds_beyond_the_last_are_refused(law, form):
    refusal = r"measured up to v = 1\.2 m/s, and its value at 1\.3 m/s is needed"
    for call in (
        lambda: form(V=[0.1, 0.65], N=1.0), lambda: form.evaluate(V="0.65", N=1),
        lambda: ss.slope_average(law)(V=0.65, N=1), lambda: ss.slope_average(law, "equilibrium")(V=1.3, N=1),
        lambda: ss.quadrature.damping(law, V="0.65", N=1), lambda: law.slope([0.1, 1.3]),
    ):  # fmt: skip
        with pytest.raises(ss.InputError, match=refusal):
            call()


def test_a_motion_beyond_the_last_speed_ends_there(law):
    osc = ss.Oscillator(m=1.0, k=100.0, c=0.0, V=0.62, N=9.81)
    refusal = r"reaches a slip speed of .* V, the law is measured up to 1\.93548 V"
    motion = ss.simulate(law, osc, t_end=10.0)
    assert motion.outcome is ss.Outcome.UNDEFINED
    assert re.search(refusal, motion.note)
    assert 1.1 < osc.V - motion.v[-1] <= 1.2
    with pytest.raises(ss.InputError, match=refusal):
        ss.simulate(law, osc, t_end=10.0, v0=-0.7)
    with pytest.raises(ss.InputError, match=refusal):
        ss.stick_slip_cycle(law, osc)
    held = ss.FrictionLaw.from_samples(SPEEDS, COEFFICIENTS, extrapolate=True)
    assert ss.stick_slip_cycle(held, osc) is not None


def test_extrapolation_holds_the_first_and_the_last_coefficient():
    with pytest.warns(ss.InputWarning, match=r"nothing was measured below v = 0\.1 m/s; mu is held there at 0\.5"):
        law = ss.FrictionLaw.from_samples([0.1, 0.2, 0.4, 0.8], [0.5, 0.4, 0.35, 0.3], extrapolate=True)
    assert law.mu([0.0, 0.05, 0.1, 0.8, 50.0]) == pytest.approx([0.5, 0.5, 0.5, 0.3, 0.3])
    assert law.v_max is None
    exact = float(ss.enclose(law, V=2, N=1))
    assert exact == pytest.approx(float(ss.quadrature.damping(law, V=2, N=1, digits=30)), rel=1e-14)


@pytest.mark.parametrize(
    ("v", "mu", "message"),
    [
        ([0, 1, 2], [1, 1, 1], "3 points were given; a curve needs 4 or more"),
        ([0, 1, 2, 3], [1, 1, 1], "v has 4 numbers and mu 3"),
        ([0, 1, 1, 3], [1, 1, 1, 1], "v of point 3, 1 m/s, repeats that of the point before"),
        ([0, 2, 1, 3], [1, 1, 1, 1], "v of point 3, 1 m/s, is below that of the point before; sort"),
        ([-1, 0, 1, 2], [1, 1, 1, 1], "v of point 1, -1 m/s, is below 0; the slip speed"),
        ([0, 1, 2, 3], [1, None, 1, 1], "mu of point 2 = None is not a finite real number"),
        ([0.1, 1, 2, 3], [1, 1, 1, 1], "the first speed is 0.1 m/s.*extrapolate=True"),
        (range(MOST + 1), range(MOST + 1), "61 points were given.*fit a law.*or average them over bins"),
        ("0123", "1111", "v is a sequence of numbers, got str"),
    ],
)
def test_points_that_are_no_curve_are_refused(v, mu, message):
    with pytest.raises(ss.InputError, match=message):
        ss.FrictionLaw.from_samples(v, mu)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"v,mu\n\xff\xfe\x00")
    for path, message in (
        (tmp_path / "none.csv", "cannot read .*No such file"),
        (tmp_path, f"cannot read .*{FOLDER_OPENED}"),
        (binary, "is not a text file of columns"),
        *((path, "the name of a file of measurements is text") for path in (None, 5)),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.FrictionLaw.from_csv(path)


def test_too_many_rows_are_refused_before_they_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip_sym.model.measured.text_table.MOST_ROWS", 1000)
    path = tmp_path / "points.csv"
    path.write_text("v,mu\n" + "1,no number\n" * 1001)
    with pytest.raises(ss.InputError, match="has over 1000 rows; average them to fewer"):
        ss.FrictionLaw.from_csv(path)


def test_a_constant_stretch_is_exactly_zero():
    """Where the criterion is 0, no number of digits tells it from a small value: the pieces do."""
    law = ss.FrictionLaw.from_samples(["0", "0.5", "0.6", "2"], ["0.5", "0.5", "0.3", "0.3"])
    form = ss.derive(law)
    assert form.evaluate(30, V="0.2", N=2) == 0
    assert str(form(V=0.2, N=2.0)) == "0.0"
    assert float(form.evaluate(30, V="0.27", N=2)) != 0
