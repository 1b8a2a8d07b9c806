"""What few rows say: weights of laws, one noise, Student's distribution, laws that do not describe them."""

import re
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import bdtr, bdtrc

import stickslip_sym as ss
from stickslip_sym.comparison.decision import Decision, unmeasured_part
from stickslip_sym.model.fitting.averaged import Averaged, ByLaw
from stickslip_sym.model.measured.measurements import Measurements
from support.sweeps import sweep

LAWS = ["linear", "exponential", "gaussian", "hyperbolic", "tanh", "lorentzian"]
FIVE = [0.05, 0.288, 0.525, 0.762, 1.0], [0.3137, 0.2132, 0.1745, 0.1595, 0.1537]
POINT = {"V": 0.5, "N": 9.81}


def slope(law):
    return ss.pure_slip_damping(law, **POINT, method="harmonic")


def least_squares(law):
    """The slope average (16) as an integral of mu."""
    nodes, shares = np.polynomial.legendre.leggauss(400)
    speeds = POINT["V"] * (1 + nodes)
    return float(-2.5 * POINT["N"] / POINT["V"] * (nodes**3 * shares) @ law.at_speeds(speeds))


def measured(count, seed, noise=0.005, name="exponential"):
    v = np.linspace(0.05, 1.1, count)
    return v, ss.laws[name].typical().mu(v) + noise * np.random.default_rng(seed).normal(size=count)


def decided(v, mu, c, laws=LAWS):
    fits = ss.fit(v, mu, laws=laws)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ss.InputWarning)  # few rows have large errors, as they should
        return Decision.of_measured(c, 0.0, fits.average(slope))


def test_five_exact_rows_decide_by_laws_that_agree():
    """An exponential to four digits: its threshold is 1.7 kg/s, and no law with more parameters is left out."""
    true = float(slope(ss.laws.exponential.bind(mu_s=0.35, mu_m=0.15, alpha=4)).value)
    fits = ss.fit(*FIVE, laws=[*LAWS, "stribeck", "exponential_viscous"])
    assert {fit.name for fit in fits.likely} == {"exponential", "stribeck", "exponential_viscous"}
    assert "too few rows to rank laws: 5 speeds" in str(fits)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ss.InputWarning)  # a viscous part may be of either sign
        decision = Decision.of_measured(0.3 * true, 0.0, fits.average(slope))
    assert decision.below is True
    low, high = decision.range
    assert low < true < high < 1.03 * low
    said = "by the 3 laws that may be meant, which agree: P > 0.99 that c is below it"
    assert decision.statement.endswith(said)
    assert not any("does not describe" in text for text in fits["exponential"].warnings)


def test_a_law_that_few_rows_do_not_determine_overflows_nowhere():
    """SciPy's covariance of its search does for these rows, and warned of it."""
    v = np.geomspace(0.02, 3, 8)
    mu = 0.2 + 0.3 * np.exp(-2 * v) + 0.005 * np.random.default_rng(1).standard_normal(8)
    with pytest.raises(ss.InputError, match="say nothing of v_0"):
        ss.fit(v, mu, laws="bengisu_akay")


def test_too_few_speeds_state_a_range_alone():
    v, mu = measured(4, 1, noise=1e-5)
    decision = decided(v, mu, 0.1, ["linear", "exponential"])
    assert (decision.below, decision.probability) == (None, None)
    assert "no decision is stated for c = 0.1 kg/s; measure at 8 speeds or more" in decision.statement, decision
    rows = [ByLaw("exponential", 1.0, 2.0, 0.0)]
    alone = Averaged.of(rows, {}, speeds=3, dof=0.0, unknown=0.0)
    nothing = Decision.of_measured(0.1, 0.0, alone)
    assert (nothing.below, nothing.probability, nothing.range) == (None, None, None)
    assert "no law has fewer parameters" in nothing.statement
    with pytest.raises(ss.InputError, match="no law has fewer parameters than the 3 speeds"):
        alone.above(0.1)


def test_laws_that_disagree_decide_nothing():
    rows = (ByLaw("one", 0.5, 1.0, 0.01), ByLaw("other", 0.5, 2.0, 0.01))
    averaged = Averaged.of(rows, {}, speeds=5, dof=2.0, unknown=0.0)
    decision = Decision.of_measured(1.5, 0.0, averaged)
    assert (decision.below, decision.probability) == (None, None)
    assert "which do not agree: P < 0.01 to P > 0.99 that c = 1.5 kg/s is below it" in decision.statement
    assert Decision.of_measured(0.5, 0.0, averaged).below is True
    assert Decision.of_measured(2.5, 0.0, averaged).below is False


def test_laws_without_a_threshold_may_say_anything():
    rows = (ByLaw("one", 0.8, 1.0, 0.01),)
    known, half = (Averaged.of(rows, {}, speeds=20, dof=15.0, unknown=unknown) for unknown in (0.0, 0.2))
    assert Decision.of_measured(0.5, 0.0, known).below is True
    assert Decision.of_measured(0.5, 0.0, half).below is None


@given(st.floats(1, 40), st.floats(0.01, 3), st.floats(0.01, 3), st.floats(-4, 4), st.integers(0, 2**32 - 1))
def test_probabilities_are_those_of_samples(dof, of_fit, of_point, distance, seed):
    """A Student variable of the fit and a normal one of the operating point, whichever is wider."""
    row = ByLaw("one", 1.0, distance, float(np.hypot(of_fit, of_point)), of_point)
    averaged = Averaged.of([row], {}, speeds=9, dof=dof, unknown=0.0)
    rng = np.random.default_rng(seed)
    samples = distance + of_fit * rng.standard_t(dof, 20_000) + of_point * rng.normal(size=20_000)
    share = np.mean(samples > 0)
    assert averaged.above(0.0) == pytest.approx(share, abs=4 * 0.5 / 20_000**0.5)
    low, high = averaged.interval()
    assert np.mean((samples > low) & (samples < high)) == pytest.approx(0.95, abs=0.01)


@pytest.mark.parametrize(("seed", "count", "exponent"), [(1, 6, -1.3), (2, 9, 1.7)])
def test_order_and_units_of_rows_change_nothing(seed, count, exponent):
    v, mu = measured(count, seed)
    laws, scale = ["linear", "exponential", "tanh"], 10**exponent
    plain = {fit.name: fit.weight for fit in ss.fit(v, mu, laws=laws)}
    mixed = np.random.default_rng(seed).permutation(count)
    for rows in ((v[mixed], mu[mixed]), (scale * v, mu), (np.r_[v, v], np.r_[mu, mu])):
        assert {fit.name: fit.weight for fit in ss.fit(*rows, laws=laws)} == pytest.approx(plain, abs=1e-4)


def test_one_law_under_two_names_weighs_once():
    v, mu = measured(12, 3)
    twice = ss.FrictionLaw("b + a*exp(-v/w)", name="twice")
    laws = ["linear", "exponential", "hyperbolic"]
    once, both = ss.fit(v, mu, laws=laws), ss.fit(v, mu, laws=[*laws, twice])
    assert both["exponential"].weight == pytest.approx(both["twice"].weight, rel=1e-6)
    assert both["exponential"].weight + both["twice"].weight == pytest.approx(once["exponential"].weight, rel=1e-4)
    first, second = once.average(slope), both.average(slope)
    assert (first.value, first.dof) == (pytest.approx(second.value, rel=1e-6), pytest.approx(second.dof))


def test_a_law_that_nobody_needs_changes_little():
    v, mu = measured(8, 4)
    without = decided(v, mu, 2.3, ["exponential", "hyperbolic"])
    beside = decided(v, mu, 2.3, ["exponential", "hyperbolic", "coulomb", "linear"])
    assert beside.probability == pytest.approx(without.probability, abs=0.01)
    assert beside.value == pytest.approx(without.value, rel=1e-3)


@sweep(("counts", "sets"), [((5, 6, 8), 6), ((5,), 400), ((8,), 400), ((16,), 400)], ((5, 6, 8), 6))
def test_intervals_of_few_rows_hold_the_truth(counts, sets):
    """At 90 % of sets or more, so far as so many sets can tell; and no confident decision is wrong."""
    rng, held, wrong = np.random.default_rng(counts[0]), 0, 0
    for seed in range(sets):
        count = counts[seed % len(counts)]
        name = str(rng.choice(LAWS))
        true = float(slope(ss.laws[name].typical()).value)
        c = true * rng.uniform(0.7, 1.3)
        decision = decided(*measured(count, seed, name=name), c)
        low, high = decision.range
        held += low <= true <= high
        sure = decision.below is not None and not 0.01 <= decision.probability <= 0.99
        wrong += sure and decision.below != (c < true)
    assert bdtr(held, sets, 0.9) > 1e-3  # so few or fewer
    assert bdtrc(wrong - 1, sets, 0.01) > 1e-3  # so many or more


@sweep(("count", "least"), [(6, 0.1), (8, 0.4), (12, 0.8)], (8, 0.4))
def test_a_law_that_does_not_describe_few_rows_is_said(count, least):
    """In the share of sets that was counted, with about one false alarm in a hundred."""
    said = {"linear": 0, "exponential": 0}
    for seed in range(20):
        for fit in ss.fit(*measured(count, seed, noise=0.008), laws=list(said)):
            said[fit.name] += any("residuals follow the speed" in text for text in fit.warnings)
    assert said["linear"] >= least * 20
    assert bdtrc(said["exponential"] - 1, 20, 0.01) > 1e-3  # so many or more


def test_studies_say_one_thing_of_few_rows():
    """Headline, verdict, page and JSON take the decision from one object."""
    from stickslip_sym.output.content import content

    fits = ss.fit(*FIVE, laws=["exponential", "exponential_viscous", "linear"])
    osc = ss.Oscillator(m=1, k=100, c=0.5, **POINT)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ss.InputWarning)
        study = ss.study(fits, osc, time_limit=300)
    assert study.headline == f"There is stick-slip from every initial condition: {study.decision.statement}."
    assert "P > 0.99" in study.headline
    shown = content(study)
    assert shown["probability"] == shown["decision"]["probability"] == study.probability
    assert shown["decision"]["below"] is True
    assert shown["margins"]["probability"] is None
    assert study.needed == (study.decision.value, study.decision.standard_error)


def test_friction_that_nobody_measured_makes_no_confident_decision():
    """Friction below the lowest speed is in the threshold: it may build up from 0 there, unseen."""
    law = ss.laws.andersson.typical(v_0=0.03)
    v = np.linspace(0.1, 1.2, 12)
    fits = ss.fit(v, law.mu(v), laws=["exponential", "exponential_viscous", "gaussian_viscous", "kragelskii"])

    def decided(c):
        def estimate(law):
            value, part = least_squares(law), unmeasured_part(law, 0.1, **POINT)
            return SimpleNamespace(value=value, uncertainty=0.0, unmeasured=part)

        return Decision.of_measured(c, 0.0, fits.average(estimate))

    true = least_squares(law)
    between = decided(0.97 * decided(1.0).value)
    assert true < between.c  # the laws alone are sure, and wrong
    assert between.probability < 0.99
    assert "friction below 0.1 m/s was not measured: if it builds up from 0 there, the threshold" in str(
        between.statement
    )
    assert between.range[0] <= true <= between.range[1]
    low = decided(0.5 * between.if_friction_builds_up)
    assert low.probability > 0.999
    assert "not measured" not in low.statement


def test_unmeasured_part_is_the_difference_of_two_thresholds():
    """A law that builds up along a line, as pieces, has a slope average less by that part."""
    law = ss.FrictionLaw("mu_k + mu_d*exp(-3*v)").bind(mu_k=0.2, mu_d=0.3)
    built_up = ss.FrictionLaw("Piecewise((v/0.05, v < 0.05), (1, True))*(0.2 + 0.3*exp(-3*v))")
    values = [least_squares(each) for each in (law, built_up)]
    assert unmeasured_part(law, 0.05, **POINT) == pytest.approx(values[0] - values[1], rel=1e-4)


def test_masked_rows_are_left_out_and_counted():
    """A mask of any column hides the row, as if it had not been measured."""
    v, mu = measured(12, 3)
    hidden = [np.ma.masked_array(v, np.arange(12) == 2), np.ma.masked_where(np.arange(12) == 7, mu)]
    left = ss.results.Measurements.of(*hidden)
    keep = ~np.isin(np.arange(12), (2, 7))
    assert (left.v.tolist(), left.mu.tolist()) == (v[keep].tolist(), mu[keep].tolist())
    assert str(left) == "10 rows, 2 masked rows left out"
    masked, plain = (ss.fit(*rows, laws="linear").best.values for rows in (hidden, (v[keep], mu[keep])))
    assert masked == plain


def test_rows_without_friction_have_branches_that_are_alike():
    v = np.r_[np.linspace(0, 1, 20), np.linspace(1, 0, 20)]
    assert not Measurements.of(v, np.zeros(40)).branches.differ


@pytest.mark.parametrize("mu", [(0.4, 0.4, 0.3, 0.2), (0.1, 0.1, 0.1, 0.1)])
def test_means_of_rows_that_agree_have_no_known_error(mu):
    """One by rounding, 3e-17, would be no measurement's, and its inverse may be infinite."""
    means = Measurements.of(np.tile([0.1, 0.4, 0.7, 1.0], 3), np.tile(mu, 3)).averaged()
    assert means.sigma is None
    assert means.mu == pytest.approx(mu, rel=1e-14)
    assert "averaged at 4 speeds, at each of which rows agree" in means.understood


def test_a_wave_in_rows_that_are_all_alike_may_have_any_frequency():
    v = np.round(np.linspace(0.9, 1.1, 60), 4)
    try:
        warned = ss.fit(v, np.full(60, 0.3), laws="a + h*sin(w*v)").best.warnings
    except ss.InputError as error:
        warned = [str(error)]
    assert re.search("describes the measurements nearly as well|say nothing of w|apart", "".join(warned))


def test_rows_of_few_digits_determine_a_law_no_better_than_their_rounding():
    """Of an exponential to four digits; a viscous part is 2.4 standard errors of the residuals from 0."""
    values, errors = [], []
    for law, name in (("exponential", "alpha"), ("exponential_viscous", "alpha"), ("exponential_viscous", "mu_v")):
        fit = ss.fit(*FIVE, laws=law).best
        values.append(fit.values[name])
        errors.append(fit.standard_errors[name])
    assert np.all(np.abs(np.subtract(values, [4, 4, 0])) < errors)
    with pytest.raises(ss.InputError, match="do not tell mu_m and alpha apart"):
        ss.fit(np.linspace(0.9, 1.1, 60), np.full(60, 0.3), laws="exponential")
