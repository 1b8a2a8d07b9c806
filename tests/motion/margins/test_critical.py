"""Critical values, put back; every one that a dense scan finds; their sensitivities; proofs; and margins."""

import math

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.margins import critical as search
from stickslip_sym.motion.orbits.needed import VelocityMismatch
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.numerics.known import Unknown
from support.operating_points import smooth_points
from support.sweeps import sample, some, sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


def put_back(law, point, of, x):
    """Return a law and an operating point with a value in its place."""
    return (law, point | {of: x}) if of in point else (law.bind(**{of: x}), point)


def value_of(law, point, of):
    return point[of] if of in point else float(law.values[of])


def without(point, of):
    return {name: value for name, value in point.items() if name != of}


@sweep(
    "method", ["equilibrium", "harmonic", "second_order", "simulation", "auto"], "harmonic", "simulation", "auto"
)
def test_put_back_they_give_the_damping(method):
    """And the sensitivities are those of the threshold there, turned round."""
    tried, rng = 0, np.random.default_rng(3)
    count = len(some(range(5), 3))
    for law, point in smooth_points(rng, count, V=(-1, -0.3), N=(0.5, 1.3)):
        average = method in ss.criteria.catalogue
        others = [] if average else ["m", "k"]
        of, factor = str(rng.choice(["N", *others, *law.parameters])), rng.uniform(0.8, 1.2)
        if average:
            point = {"V": point["V"], "N": point["N"]}
        x0 = value_of(law, point, of)
        c = ss.pure_slip_damping(law, **point, method="orbit" if method == "auto" else method).value * factor
        within = (x0 / 3, 3 * x0)
        given = without(point, of) | {"method": method, "rtol": 0.3 if method == "second_order" else 1e-6}
        for one in ss.critical(law, of, c=c, **given, within=within):
            there, point_there = put_back(law, point, of, one.value)
            same = ss.pure_slip_damping(there, **point_there, method=one.method, rtol=1e-10)
            assert same.value == pytest.approx(c, rel=1e-9)
            if one.method == "orbit":
                other = ss.pure_slip_damping(there, **point_there, method="simulation", rtol=1e-10)
                assert other.value == pytest.approx(c, rel=1e-9)
            if method == "second_order":
                (exact,) = ss.critical(law, of, c=c, **given | {"method": "orbit"}, within=within)
                assert abs(one.value / exact.value - 1) <= one.relative_error
            assert one.sensitivity["c"] == pytest.approx(1 / same.sensitivity[of], rel=1e-6)
            expected = -same.sensitivity["V"] / same.sensitivity[of]
            assert one.sensitivity["V"] == pytest.approx(expected, rel=1e-6)
            tried += 1
    assert tried >= 2


KINK = ss.FrictionLaw("Piecewise((mu_s - a*v, v < v_1), (mu_s - a*v_1 + b*(v - v_1), True))")
POINTS = [0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2], [0.5, 0.44, 0.4, 0.34, 0.29, 0.27, 0.26]
DROP = ss.FrictionLaw("Piecewise((0.5, v < 1), (0.3, True))")
PIECES = {
    "kink": (KINK.bind(mu_s=0.5, a=0.4, b=0.1, v_1=0.3), "v_1", 0.3, {}, (0.2, 0.4)),
    # Where a motion goes beyond the last measured speed there is no threshold, and others are found.
    "points": (ss.FrictionLaw.from_samples(*POINTS), "N", 2.0, {}, (8.0, 100.0)),
    "static": (ss.FrictionLaw("0.3", static="0.35"), "V", 0.1, {}, None),
    "a drop that is touched": (DROP, "V", 2.27, {"N": 20}, (0.5, 0.8)),
    "a drop at one of the speeds": (DROP, "V", 2.27, {"N": 20}, (0.8, 1.0, 1.3)),
    "kinked in V": (ss.FrictionLaw("0.2 + 0.3*Max(0, 1 - v/0.3)"), "V", 2.0, {"k": 1e4}, None),
}


@sample(3)
@pytest.mark.parametrize("name", PIECES)
def test_laws_that_are_not_smooth_by_simulation(name):
    law, of, c, changes, within = PIECES[name]
    point = POINT | changes
    (one,) = ss.critical(law, of, c=c, **without(point, of), within=within, rtol=1e-6)
    assert one.method == "simulation"
    there, point = put_back(law, point, of, one.value)
    assert ss.pure_slip_damping(there, **point, method="simulation", rtol=1e-10).value == pytest.approx(
        c, rel=1e-8
    )
    with pytest.raises(ss.InputError, match="needs a law that is smooth"):
        ss.critical(law, of, c=c, **without(point, of), method="orbit")


def test_all_that_a_dense_scan_finds():
    """By averages over four decades of a parameter, on seeded laws that have up to three."""
    rng, several, scan = np.random.default_rng(9), 0, np.geomspace(1e-3, 10, 4001)
    for _ in some(range(3), 2):
        law = ss.laws.two_exponentials.typical(d_1=rng.uniform(0.05, 0.3), d_2=rng.uniform(0.05, 0.3))
        c, average = rng.uniform(0.5, 3), ss.slope_average(law, "harmonic")
        expected = np.flatnonzero(np.diff(np.sign(average(V=0.5, N=9.81, v_1=scan) - c)) != 0)
        found = [one.value for one in ss.critical(law, "v_1", c=c, V=0.5, N=9.81, within=(1e-3, 10))]
        assert (np.searchsorted(scan, found) == expected + 1).all()
        assert average(V=0.5, N=9.81, v_1=np.array(found)) == pytest.approx(c, rel=1e-9)
        several += len(found) > 1
    assert several >= 1


def test_polynomial_averages_need_no_range():
    signed = [ss.Parameter("b", positive=False)]
    law = ss.FrictionLaw("0.6 - b*v + b^2*v^2*a", parameters=signed).bind(a=0.3)
    for c in (0.5, -0.5):  # c = N (b - b^2 a) at V = 0.5
        roots = ss.critical(law, "b", c=c, V=0.5, N=9.81, method="equilibrium")
        last = max(one.value for one in roots)
        near = ss.critical(law, "b", c=c, V=0.5, N=9.81, method="equilibrium", within=(0.9 * last, 1.1 * last))
        assert [one.value for one in near] == [last]
        assert [one.value for one in roots] == pytest.approx(sorted(np.roots([-9.81 * 0.3, 9.81, -c])), rel=1e-12)
    assert ss.critical(ss.laws.coulomb_viscous.typical(), "N", c=1.0, V=0.5, method="equilibrium") == ()


@sweep(
    ("speeds", "count"), [((0.3, 0.35), 1), ((0.3, 0.7), 2)], ((0.3, 0.35), 1)
)  # the second speed, 0.688 m/s, takes long
def test_averages_of_a_steep_fall(speeds, count):
    """Stribeck's law with an exponent of 60 falls at v_s as a step does, between the nodes of a fixed rule."""
    law, point = ss.laws.stribeck_viscous.typical(delta=60), {"V": 0.5, "N": 9.81}
    cosine = np.cos((np.arange(4000) + 0.5) * np.pi / 4000)
    for of, within in some((("mu_s", None), ("v_s", speeds), ("N", None)), 2):
        roots = ss.critical(law, of, c=3.0, **without(point, of), within=within)
        assert len(roots) == (count if of == "v_s" else 1)
        for one in roots:
            there, at = put_back(law, point, of, one.value)
            work = there.at_speeds(at["V"] * (1 + cosine)) @ cosine / cosine.size
            assert -2 * at["N"] / at["V"] * work == pytest.approx(3.0, rel=1e-9)
    assert ss.critical(law, "delta", c=3.5, **point, within=(60, 90)) == ()  # the average comes up to 3.26 only


@pytest.mark.parametrize(
    ("method", "square"), [("equilibrium", 1), ("least_squares", 21 / 26), ("harmonic", 12 / 15)]
)
def test_speeds_of_a_polynomial_law_in_closed_form(method, square):
    law = ss.laws.polynomial.typical(v_m=2)
    (speed,) = ss.critical(law, "V", c=0.0, N=9.81, method=method)
    assert speed.value == pytest.approx(2 * math.sqrt(square), rel=1e-14)
    assert ss.critical(law, "V", c=3.0, N=9.81, method=method) == ()


def test_the_asymptotes_as_the_damping_vanishes():
    """least_squares: c = (5/2) N D/(alpha V^2); harmonic: c = N D sqrt(2/(pi alpha)) V^-3/2."""
    law, ND, alpha = ss.laws.exponential.typical(), 9.81 * 0.3, 3.0
    for c in (1e-6, 1e-9):
        for method, speed in (
            ("least_squares", math.sqrt(2.5 * ND / (alpha * c))),
            ("harmonic", (ND / c * math.sqrt(2 / (math.pi * alpha))) ** (2 / 3)),
        ):
            (found,) = ss.critical(law, "V", c=c, N=9.81, method=method)
            assert found.value == pytest.approx(speed, rel=10 / (alpha * speed))
    assert ss.critical(law, "V", c=0.0, N=9.81) == ()


def test_damping_and_zero_damping_are_critical_too():
    """The relative error of the threshold is nothing at c = 0."""
    # Sought at all speeds it takes minutes: far from the average's own root no orbit is asked.
    (speed,) = ss.critical(
        ss.laws.polynomial.typical(), "V", c=0.0, **without(POINT, "V"), method="orbit", time_limit=10
    )
    assert 0 < speed.relative_error < 1e-6
    (close,) = ss.critical(
        ss.laws.polynomial.typical(),
        "V",
        c=0.0,
        **without(POINT, "V"),
        method="orbit",
        rtol=1e-9,
        within=(0.6, 1.2),
    )
    assert abs(speed.value - close.value) <= (speed.relative_error + close.relative_error) * close.value
    law, osc = ss.laws.exponential.typical(), ss.Oscillator(c=2.0, **POINT)
    (damping,) = ss.critical(law, "c", **POINT, method="orbit")
    assert damping.value == ss.pure_slip_damping(law, **POINT, method="orbit").value
    assert ss.critical(law, "N", osc)[0].value == ss.critical(law, "N", c=2.0, **without(POINT, "N"))[0].value
    with pytest.raises(ss.InputError, match="N was given beside an Oscillator"):
        ss.critical(law, "V", osc, N=1.0)


@pytest.mark.parametrize("size", [1e-6, 2.0, 1e5])
def test_two_close_together_and_none(size):
    """At a dip of the harmonic threshold over a parameter, whose roots are known, whatever its size."""
    law = ss.FrictionLaw("0.5 - 0.3*v + 0.2*(log(a) - b)^2*v", parameters=[ss.Parameter("b", positive=False)])
    off = math.sqrt(1e-3 / (9.81 * 0.2))
    for below, roots in ((1e-3, [math.exp(-off), math.exp(off)]), (-1e-3, [])):
        given = {"c": 9.81 * 0.3 - below, "V": 0.5, "N": 9.81, "within": (0.15 * size, 5.5 * size)}
        found = ss.critical(law.bind(b=math.log(size)), "a", **given)
        assert [one.value / size for one in found] == pytest.approx(roots, rel=1e-8)


def test_proved_values_enclose_what_the_orbit_finds():
    law = ss.laws.exponential.typical()
    for of in ("V", "mu_s"):
        given = {"within": (0.3, 0.9), "c": 2.0, **without(POINT, of)}
        (orbit,) = ss.critical(law, of, **given, method="orbit", rtol=1e-9)
        (proof,) = ss.critical(law, of, **given, method="proof", rtol=1e-8)
        assert float(proof.enclosure.low) < orbit.value < float(proof.enclosure.high)
        assert proof.relative_error <= 0.5e-8
        assert "PROVED" in str(proof)


OSC = ss.Oscillator(c=2.8, **POINT)
REFUSED = [
    (ss.critical, "mu_x", {"c": 1, "V": 1, "N": 1}, "there is no quantity or parameter 'mu_x'"),
    (ss.critical, "N", {"c": 1, "V": 1, "N": 1}, "N is sought; leave its value out"),
    (ss.critical, "mu_s", {"V": 1, "N": 1}, r"c must be given to find mu_s: c=\.\.\."),
    (ss.critical, "k", {"c": 1, "V": 1, "N": 1, "method": "harmonic"}, "does not depend on k"),
    (ss.critical, "k", {"c": 1, "V": 1, "N": 1, "m": 1, "method": "harmonic"}, "does not depend on k"),
    *((ss.critical, "alpha", {"c": 1, "V": 1, "N": 1, "within": within}, "two numbers of one sign, ascending")
      for within in ((2, 1), 5)),
    (ss.critical, "alpha", {"c": 1, "V": 1, "N": 1, "within": ("x", 1)}, "is not a number"),
    (ss.margins, OSC, {"errors": "9.8(2)"}, "errors is a mapping such as"),
    (ss.margins, OSC, {"samples": "many"}, "samples is a whole number"),
    (ss.margins, OSC, {"samples": -1}, "samples = -1 must not be negative"),
    (ss.margins, OSC, {"reach": "far"}, "reach = 'far' is not a number"),
    (ss.margins, OSC, {"each": -1}, "time_limit = -1 is not a number of seconds"),
    (ss.margins, OSC, {"errors": {"N": "9.8(2)"}}, "N is 9.81 in the oscillator and 9.8 in errors; give the same"),
    (ss.margins, OSC, {"errors": {"mu_s": "0.5(1)"}}, "errors has 'mu_s'; it takes V, N, m, k and c"),
]  # fmt: skip


@pytest.mark.parametrize(("function", "of", "given", "message"), REFUSED)
def test_what_cannot_be_found_is_refused(function, of, given, message):
    with pytest.raises(ss.InputError, match=message):
        function(ss.laws.exponential.typical(), of, **given)


@pytest.fixture(scope="module")
def found():
    law = ss.laws.exponential.typical(mu_s="0.50(3)")
    return ss.margins(law, ss.Oscillator(c=2.8, **POINT), errors={"N": "9.81(20)"}, samples=80)


def test_margins_are_the_nearest_critical_values(found):
    assert not found.stick_slip
    rows = {row.name: row for row in found.rows}
    assert set(rows) == {"c", "V", "N", "m", "k", "mu_s", "mu_m", "alpha"}
    assert rows["c"].below.value == pytest.approx(2.573078879, rel=1e-3)
    assert rows["c"].above is None
    assert rows["V"].below.value < 0.5
    assert rows["V"].change < 0 < rows["N"].change
    changes = [abs(row.change) for row in found.rows]
    assert changes == sorted(changes)


def test_margins_keep_to_reach_and_time(found):
    law, osc = ss.laws.exponential.typical(), ss.Oscillator(c=2.8, **POINT)
    whole = {row.name: row.change for row in found.rows}
    for row in ss.margins(law, osc, reach=1.06, samples=0).rows:
        within = row.name in ("c", "mu_s")  # that of c needs no search
        assert row.change == (pytest.approx(whole[row.name], rel=1e-6) if within else math.inf)
        assert within == (row.name == "c" or 1 / 1.06 <= 1 + whole[row.name] <= 1.06)
    hurried = ss.margins(law, osc, each=1e-9, samples=0)
    assert (hurried.rows, hurried.refused) == ((), dict.fromkeys(whole, "not found within 1e-09 s"))


def test_the_probability_of_stick_slip(found):
    """To first order the normal distribution's, of both errors; and that of samples beside it."""
    s = found.threshold.sensitivity
    spread = math.hypot(0.03 * s["mu_s"], 0.2 * s["N"])
    below = 0.5 * math.erfc((2.8 - found.threshold.value) / spread / math.sqrt(2))
    assert found.probability == pytest.approx(below, rel=1e-9)
    assert 0.1 < below < 0.3
    assert abs(found.sampled.probability - below) < 4 * found.sampled.standard_error
    assert found.sampled.undecided == 0
    assert "probability that stick-slip is possible: 0.1" in str(found) or "possible: 0.2" in str(found)
    assert found._repr_html_().count("<tr>") == 9


def test_samples_without_a_threshold_or_an_answer():
    """A slope that is positive as a whole needs no damping, and c > 0 suffices; a negative alpha is undecided."""
    law = ss.FrictionLaw("0.5 - a*Min(v, 0.5) + b*Max(v - 0.5, 0)").bind(a="0.30(5)", b=0.28)
    found = ss.margins(law, ss.Oscillator(c=0.01, **POINT), samples=60, reach=1.05)
    assert abs(found.sampled.probability - found.probability) < 4 * found.sampled.standard_error
    assert found.sampled.undecided < 0.1
    law = ss.laws.exponential.typical(alpha="3.0(20)")
    found = ss.margins(law, ss.Oscillator(c=2.0, **POINT), samples=60, reach=1.05)
    assert 0.02 < found.sampled.undecided < 0.2
    assert "% undecided" in str(found)


def test_a_mismatch_that_is_not_known_is_no_critical_value(monkeypatch):
    """It was taken for one whose sign rounding hides, and so for a root."""
    points = OperatingPoints.of(ss.laws.exponential.typical(), **POINT)
    assert search.excess(points, 2.0, None) > 0 > search.excess(points, 3.0, None)
    lost = VelocityMismatch(math.nan, 0.0, False, math.inf, math.inf)
    monkeypatch.setattr(search, "velocity_mismatch_at", lambda *_, **__: lost)
    assert isinstance(search.excess(points, 2.0, None), Unknown)
    osc = ss.Oscillator(c=2.3, **POINT)
    with pytest.raises(ss.NotConverged, match=r"there is no threshold at N = .*: the halves of the grazing orbit"):
        ss.critical(ss.laws.exponential.typical(), "N", osc, within=(5, 20))


@pytest.mark.parametrize(
    ("name", "of", "values"),
    [
        ("exponential", "alpha", (1.0, 5.0)),
        ("gaussian", "v_s", (0.1, 0.9)),
        ("exponential", "mu_s", (0.4, 0.7)),
        ("exponential", "mu_s", (0.05, 0.15)),
        ("tanh", "mu_m", (0.6, 0.8)),
    ],
)
def test_values_that_scale_slip_speed_or_friction_are_points_of_one_law(name, of, values):
    """And have the thresholds that their own laws have; for friction that rises with speed too."""
    law = ss.laws.catalogue[name].typical()
    found = search._Search(law, of, POINT | {"c": 1.0}, None, 1e-3)
    alike = found._alike(np.array(values))
    assert len(alike) == len(values)
    for i, x in enumerate(values):
        own = ss.pure_slip_damping(law.bind(**{of: x}), **POINT, rtol=1e-6)
        same = ss.pure_slip_damping(alike.law, V=alike.V[i], N=alike.N[i], m=1.0, k=100.0, rtol=1e-6)
        assert same.value == pytest.approx(own.value, rel=3e-6)


@pytest.mark.parametrize(("name", "of"), [("stribeck", "delta"), ("stribeck_viscous", "v_s")])
def test_values_that_shape_a_law_have_laws_of_their_own(name, of):
    """A scale of one term of several is no scale of the law."""
    found = search._Search(ss.laws.catalogue[name].typical(), of, POINT | {"c": 1.0}, None, 1e-3)
    assert found.similarity is None
    assert len({found._kin(x) for x in (0.5, 1.0, 2.0)}) == 3
