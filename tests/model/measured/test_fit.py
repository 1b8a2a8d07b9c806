"""Fits held against known truth, lmfit with numerical derivatives, and propagation by uncertainties."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core.probabilities import NORMAL
from stickslip_sym.core.uncertain import interval_text, text_with_error
from stickslip_sym.model.measured.measurements import Measurements
from support.sweeps import sweep

TRUE = {"mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
NOISE = 0.01
RIVALS = [
    "exponential", "gaussian", "logarithmic", "coulomb_viscous", "hyperbolic", "polynomial", "tanh",
    "bengisu_akay",
]  # fmt: skip


def data(law=ss.laws.exponential, *, seed=0, count=60, low=2e-3, noise=NOISE):
    """Speeds, spread over decades, and coefficients with seeded noise."""
    rng = np.random.default_rng(seed)
    v = np.exp(rng.uniform(np.log(low), np.log(2.0), count))
    return v, law.typical().mu(v) + noise * rng.normal(size=count)


@pytest.fixture(scope="module")
def fits():
    return ss.fit(*data(), laws=["exponential", "gaussian", "coulomb", "stribeck"])


def correlated(rng, count, rho):
    """Noise in which each value keeps a part rho of the one before."""
    noise = rng.normal(size=count)
    for i in range(1, count):
        noise[i] = rho * noise[i - 1] + np.sqrt(1 - rho**2) * noise[i]
    return noise


@sweep(
    ("rho", "known", "sets", "within"),
    [(0.0, False, 200, 0.0), (0.0, True, 60, 0.02), (0.5, False, 60, 0.0), (0.8, False, 60, 0.0),
     (0.0, False, 40, 0.03), (0.8, False, 20, 0.0)],
    (0.0, False, 40, 0.03), (0.8, False, 20, 0.0),
)  # fmt: skip
def test_intervals_hold_the_truth_as_stated(rho, known, sets, within):
    """At 80 % they must be too narrow for 92 %, or nothing would be measured; fewer sets scatter more.

    Unwidened, they hold it in 38 to 61 of 100 where noise is correlated by 0.8.
    """
    rng = np.random.default_rng(17)
    v = np.linspace(0.01, 1.5, 80)
    held, plain, warned = {0.95: [], 0.8: []}, [], 0
    for _ in range(sets):
        mu = 0.2 + 0.3 * np.exp(-3 * v) + NOISE * correlated(rng, 80, rho)
        best = ss.fit(v, mu, NOISE if known else None, laws="exponential").best
        warned += any("are correlated" in text for text in best.warnings)
        for level, found in held.items():
            intervals = best.confidence(level)
            found += [low <= TRUE[name] <= high for name, (low, high) in intervals.items()]
        half = {name: (high - low) / 2 / best.inflation**0.5 for name, (low, high) in best.confidence().items()}
        plain += [abs(best.values[name] - TRUE[name]) <= half[name] for name in TRUE]
    assert np.mean(held[0.95]) >= 0.92 - within
    assert (warned > 0.83 * sets) if rho else (warned < 0.08 * sets)
    if not rho:
        assert np.mean(held[0.95]) <= 0.97 + within
        assert 0.74 - within <= np.mean(held[0.8]) <= 0.86 + within
    assert rho < 0.8 or np.mean(plain) < 0.8


@sweep("name", list(ss.laws), "stribeck_viscous", "two_exponentials", "cubic")
def test_a_law_is_found_again_without_noise(name):
    """From starts that know nothing of the values."""
    law = ss.laws[name]
    v, mu = data(law, low=1e-4, noise=1e-9, count=120)
    found = ss.fit(v, mu, laws=law).best.values
    assert found == pytest.approx({key: float(value) for key, value in law.typical().values.items()}, rel=1e-4)


@given(st.floats(-6, 4))
def test_another_unit_of_speed_scales_the_values(exponent):
    (v, mu), scale = data(count=20), 10**exponent
    found, plain = (ss.fit(v * unit, mu, laws="exponential").best.values for unit in (scale, 1))
    assert found == pytest.approx(plain | {"alpha": plain["alpha"] / scale}, rel=1e-6)


@sweep("rivals", [RIVALS[:3], RIVALS], RIVALS[:3])
def test_the_generating_law_is_among_the_best_two(rivals):
    first = []
    for name in rivals:
        v, mu = data(ss.laws.catalogue[name], count=100, low=1e-4, noise=0.002)
        fits = ss.fit(v, mu, laws=rivals)
        assert sum(fit.weight for fit in fits) == pytest.approx(1)
        assert [fit.weight for fit in fits] == sorted((fit.weight for fit in fits), reverse=True)
        first.append([fit.name for fit in fits].index(name))
    assert np.mean(np.array(first) < 2) >= 0.9


@pytest.mark.parametrize("sigma", [None, 0.02])
def test_lmfit_with_numerical_derivatives_finds_the_same(fits, sigma):
    import lmfit

    v, mu = data()
    fit = ss.fit(v, mu, sigma, laws="exponential").best

    def residual(p):
        return (p["mu_m"] + (p["mu_s"] - p["mu_m"]) * np.exp(-p["alpha"] * v) - mu) / (sigma or 1)

    parameters = lmfit.Parameters()
    for name in TRUE:
        parameters.add(name, value=1.0)
    other = lmfit.minimize(residual, parameters, scale_covar=sigma is None)
    for name, parameter in other.params.items():
        assert fit.values[name] == pytest.approx(parameter.value, rel=1e-6)
        assert fit.standard_errors[name] == pytest.approx(parameter.stderr, rel=1e-4)
    assert fit.chi_squared == pytest.approx(other.chisqr)
    if sigma is None:
        k, n = 4, len(v)
        assert fit.aicc == pytest.approx(other.aic + 2 + 2 * k * (k + 1) / (n - k - 1))
        assert fit.sigma == pytest.approx(np.sqrt(other.redchi))


def test_the_band_is_what_uncertainties_propagates(fits):
    from uncertainties import umath

    fit = fits["exponential"]
    p = fit.uncertain
    for v in (0.01, 0.3, 1.5):
        mu = p["mu_m"] + (p["mu_s"] - p["mu_m"]) * umath.exp(-p["alpha"] * v)
        low, high = fit.band([v], level=0.6826894921370859)
        below, above = fit.confidence(0.6826894921370859)["alpha"]
        one_sided = (above - below) / 2 / fit.standard_errors["alpha"]
        assert (low[0] + high[0]) / 2 == pytest.approx(mu.nominal_value)
        assert (high[0] - low[0]) / 2 == pytest.approx(one_sided * mu.std_dev, rel=1e-6)
    assert fit.law.mu(0.3) == pytest.approx((p["mu_m"] + (p["mu_s"] - p["mu_m"]) * umath.exp(-p["alpha"] * 0.3)).n)


def test_profiles_agree_with_standard_errors(fits):
    fit = fits["exponential"]
    profile, plain = fit.confidence(profile=True), fit.confidence()
    for name, error in fit.standard_errors.items():
        assert profile[name] == pytest.approx(plain[name], abs=0.15 * error)
    assert profile["alpha"][1] - fit.values["alpha"] > fit.values["alpha"] - profile["alpha"][0]  # it is skew


@given(st.floats(-1e3, 1e3), st.floats(1e-9, 1e3))
def test_intervals_never_collapse_in_text(middle, half):
    low, high = map(float, interval_text(middle - half, middle + half).split(" to "))
    assert abs(high - low - 2 * half) <= 0.06 * half


def test_a_negative_value_is_held_at_zero():
    v, mu = data(noise=0.001)
    fit = ss.fit(v, mu - 0.02 * v, laws="exponential_viscous").best
    assert fit.values["mu_v"] == 0
    assert any("mu_v is held at its bound 0" in text and "law.bind(mu_v=0)" in text for text in fit.warnings)
    assert any("Parameter('mu_v', positive=False)" in text for text in fit.warnings)
    for sign, positive in ((1, False), (-1, True)):
        slope = ss.Parameter("d", positive=positive)
        law = ss.FrictionLaw(f"a + b*exp(-alpha*v) + {sign}*d*v", parameters=[slope])
        assert ss.fit(v, mu - 0.02 * v, laws=law).best.values["d"] == pytest.approx(-0.02 * sign, abs=0.004)


def test_laws_without_a_jump_need_low_speeds():
    law = ss.laws.bengisu_akay
    v, mu = data(law, low=1e-3, noise=0.002)
    assert ss.fit(v, mu, laws=law).best.values["v_0"] == pytest.approx(0.01, rel=0.1)
    above = v > 0.08
    with pytest.raises(ss.InputError, match=r"say nothing of v_0|builds up below|do not tell .*v_0"):
        ss.fit(v[above], mu[above], laws=law)


def test_what_cannot_be_told_apart_is_said():
    v, mu = data(ss.laws.stribeck, noise=0.003)
    for count, law, message in (
        (60, "a*b/(1 + v)", r"do not tell a and b apart; fix one: law\.bind\([ab]=\.\.\.\)"),
        (60, "Piecewise((a - b*v, v < v_1 + v_2), mu_d)", "at a place that several free parameters move"),
        (4, "stribeck", "4 free parameters, and 4 rows at 4 speeds are too few"),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.fit(v[:count], mu[:count], laws=law)
    fixed = ss.fit(v, mu, laws=ss.laws.stribeck.bind(delta=1.5)).best
    assert set(fixed.values) == {"mu_s", "mu_m", "v_s"}
    assert float(fixed.law.values["delta"]) == 1.5
    assert not fixed.warnings
    loose = ss.fit(v[v < 0.1], mu[v < 0.1], laws="stribeck").best
    assert any("hardly" in text and "law.bind(" in text for text in loose.warnings)


def test_a_fit_reports_itself(fits, tmp_path):
    assert all(words in str(fits) for words in ("exponential", "AICc above"))
    assert "+/-" in str(fits.best)
    for fit in fits:
        likely = fit.weight >= 0.01 * fits.best.weight
        assert all((text in str(fits)) == likely for text in fit.warnings)
        assert fit.noise in str(fit)
        bound = fit.law.bind(**fit.uncertain)
        assert all(
            text_with_error(fit.values[name], error) in bound._repr_html_()
            for name, error in fit.standard_errors.items()
        )
    assert [one["law"]["name"] for one in json.loads(fits.to_json())["fits"]] == [fit.name for fit in fits]
    one = json.loads(fits["gaussian"].to_json())
    assert one["law"]["parameters"]["v_s"]["unit"] == "m/s"
    assert one["covariance"][0][1] == one["covariance"][1][0]
    for one in (fits, fits.best, fits.measured):
        assert repr(one).startswith(f"{type(one).__name__}: ")
        assert "\n" not in repr(one)
    with pytest.raises(ss.InputError, match="did you mean 'gaussian'"):
        _ = fits["gausian"]
    low, high = fits.best.measured.v[[0, -1]]
    said = [fits.best.extrapolation(v) for v in (0.6 * high, 0.5 * low, 0.4 * high)]
    assert (said[0][:18], "below" in said[1], said[2]) == ("extrapolated above", True, None)
    pytest.importorskip("matplotlib")
    assert "<table>" in fits._repr_html_()
    assert "<table>" in fits.best._repr_html_()
    above, below = fits.plot(tmp_path / "fit.svg").axes
    assert len(above.lines[0].get_xdata()) == len(below.lines[0].get_xdata()) == 60
    low, high = fits.best.band(above.lines[1].get_xdata())
    assert {*low, *high} <= {*above.collections[-1].get_paths()[0].vertices[:, 1]}  # Student's, not the normal one
    assert (tmp_path / "fit.svg").stat().st_size > 5000


def test_what_residuals_show_is_warned_of():
    """A sigma three times too small or too large, and a law that repeats at one speed contradict."""
    v, mu = data()
    for sigma, words in (
        (NOISE, ""), (NOISE / 3, "or sigma is too small"), (NOISE * 3, "too large; if each mu is the mean"),
    ):  # fmt: skip
        warned = ss.fit(v, mu, sigma, laws="exponential").best.warnings
        assert any(words in text for text in warned) if words else not warned
    rng = np.random.default_rng(4)
    v = rng.permutation(np.repeat(np.linspace(0.05, 1.2, 8), 6))
    mu = 0.2 + 0.3 * np.exp(-6 * v) + NOISE * rng.normal(size=48)
    for sigma in (None, NOISE):
        fits = ss.fit(v, mu, sigma, laws=["linear", "exponential"])
        assert any("repeats at one speed scatter by" in text for text in fits["linear"].warnings)
        assert not fits["exponential"].warnings


def slow_noise(kind, rng, v):
    """Rows in some order with noise of size 1 that is not independent: speeds and noise."""
    count, mixed = len(v), rng.permutation(len(v))
    if kind == "blocks":
        noise = (np.repeat(rng.normal(size=count // 8), 8) + 0.5 * rng.normal(size=count)) / 1.25**0.5
    elif kind == "interleaved":
        noise, mixed = np.empty(count), np.arange(count)
        noise[::2], noise[1::2] = (correlated(rng, count // 2, 0.8) for _ in range(2))
    else:
        noise = np.repeat(rng.normal(size=count // 2), 2)
        v = np.repeat(v[::2], 2) if kind == "pairs of one speed" else v
    return v[mixed], noise[mixed]


@sweep(
    ("kind", "least", "plainly", "sets"),
    [("blocks", 0.7, 0.75, 20), ("interleaved", 0.75, 0.85, 20), ("pairs", 0.93, 0.93, 20),
     ("pairs of one speed", 0.93, 0.93, 200), ("blocks", 0.8, 0.7, 200), ("interleaved", 0.85, 0.75, 200)],
    ("blocks", 0.7, 0.75, 20), ("interleaved", 0.75, 0.85, 20), ("pairs", 0.93, 0.93, 20),
)  # fmt: skip
def test_intervals_allow_for_noise_in_any_order(kind, least, plainly, sets):
    """Along the speed where the file is shuffled, and two rows apart; unwidened, intervals hold too little."""
    rng, held, plain = np.random.default_rng(5), [], []
    for _ in range(sets):
        v, noise = slow_noise(kind, rng, np.linspace(0.01, 1.5, 80))
        best = ss.fit(v, 0.2 + 0.3 * np.exp(-3 * v) + NOISE * noise, laws="exponential").best
        assert best.noise.split(", ")[0] in (
            f"noise is taken as {kind}" for kind in
            ("independent from row to row", "correlated along the speed", "correlated along the file")
        )  # fmt: skip
        assert best.inflation == 1 or any("are correlated" in text for text in best.warnings)
        for name, (low, high) in best.confidence().items():
            off, half = abs(best.values[name] - TRUE[name]), (high - low) / 2
            held.append(off <= half)
            plain.append(off <= half / best.inflation**0.5)
    assert np.mean(held) >= least
    assert np.mean(plain) < plainly


def test_slow_noise_says_nothing_of_sigma():
    """It has a large sum of squares as often as it has a small one."""
    v = np.linspace(0.01, 1.5, 100)
    slow = 0.4 - 0.1 * v + NOISE * correlated(np.random.default_rng(8), 100, 0.9)
    fit = ss.fit(v, slow, 0.75 * NOISE, laws="linear").best
    assert fit.chi_squared > 1.5 * fit.dof
    assert "along the file" in fit.noise
    assert not any("sigma is too small" in text for text in fit.warnings)


FEATURES = {
    "jump": ("Piecewise((a - b*v, v < w), (d, True))", {"b": 0.1, "d": 0.35}, (0.1, 1.4), 0.0),
    "two jumps": ("Piecewise((a, v < w), (d, v < 1.2), (0.3, True))", {"d": 0.4}, (0.1, 1.1), 0.0),
    "kink": ("a - b*v + d*Abs(v - w)", {"b": 0.1, "d": 0.2}, (0.3, 1.2), 0.01),
    "bump": ("a - b*v + d*exp(-((v - w)/u)^2)", {"b": 0.1, "d": 0.1, "u": 0.06}, (0.2, 1.3), 0.01),
    "frequency": ("a + h*sin(w*v)", {"h": 0.02}, (4, 150), 0.05),
    "wave length": ("a + h*cos(2*pi*v/w + 1)", {"h": 0.02}, (0.05, 1), 0.05),
    "phase": ("a + b*exp(-3*v) + h*cos(w*v + f)", {"b": 0.1, "h": 0.02}, (10, 100), 0.05),
}  # fmt: skip
"""A law, its values besides a and w, between which w is drawn, and by how much w may then be off, relatively."""


@given(st.sampled_from(list(FEATURES)), st.integers(0, 2**32 - 1))
def test_places_and_frequencies_are_found_again(kind, seed):
    """The best of all minima: at a value beside it the sum of squares is larger, save within a jump's gap."""
    text, values, within, off = FEATURES[kind]
    rng, law = np.random.default_rng(seed), ss.FrictionLaw(text)
    for turn in range(6 if kind == "phase" else 1):
        v, w = np.sort(rng.uniform(0.01, 1.5, 90)), float(np.exp(rng.uniform(*np.log(within))))
        true = {"a": 0.5, "w": w} | values | ({"f": turn + float(rng.uniform(0.01, 1))} if kind == "phase" else {})
        mu = law.bind(**true).mu(v) + 0.001 * rng.normal(size=90)
        fit = ss.fit(v, mu, laws=law).best
        assert fit.sigma < 0.0014
        low, high = fit.confidence(0.9999)["w"]
        assert low <= w <= high
        assert abs(fit.values["w"] - w) <= (off * w if off else 3 * np.diff(v).max())
        assert (fit.jumps == ("w",)) == ("jump" in kind)
        if off and kind != "bump":
            beside = law.bind(**fit.values | {"w": fit.values["w"] * 1.02})
            assert np.sum((mu - beside.mu(v)) ** 2) > 1.05 * fit.chi_squared


@sweep("sets", [20, 200], 20)
def test_intervals_of_jumps_hold_the_truth(sets):
    """Where a quantile of chi-squared, as of a smooth law, holds it in 80 of 100."""
    rng, v, held, sizes = np.random.default_rng(6), np.linspace(0.01, 1.5, 60), [], []
    for _ in range(sets):
        mu = np.where(v < 0.6217, 0.5, 0.5 - 1.5 * NOISE) + NOISE * rng.normal(size=60)
        fit = ss.fit(v, mu, laws="Piecewise((a, v < w), (d, True))").best
        low, high = fit.confidence()["w"]
        held.append(low <= 0.6217 <= high)
        sizes.append((high - low) / np.diff(v)[0])
        assert fit.standard_errors["w"] == pytest.approx((high - low) / 2 / NORMAL)
    assert np.mean(held) >= 0.92
    assert 0.999 < np.min(sizes) < np.mean(sizes) < 14
    with pytest.raises(ss.InputError, match="say nothing of w; fix it"):
        ss.fit(v, 0.4 + NOISE * rng.normal(size=60), laws="Piecewise((a, v < w), (d, True))")


def test_a_frequency_that_noise_may_have_chosen_is_warned_of():
    rng, v = np.random.default_rng(9), np.linspace(0.01, 1.5, 60)
    noise = NOISE * rng.normal(size=60)
    for height, rivals in ((0.05, False), (0.0, True)):
        fit = ss.fit(v, 0.4 + height * np.sin(40 * v) + noise, laws="a + h*sin(w*v)").best
        assert any("describes the measurements nearly as well" in text for text in fit.warnings) == rivals


def test_three_rows_suffice_for_one_parameter():
    steps = []
    law = ss.laws.linear.bind(mu_s=0.4)
    fits = ss.fit([0.1, 0.5, 1.0], [0.38, 0.31, 0.2], laws=law, progress=lambda *done: steps.append(done))
    assert steps == [(0, 1), (1, 1)]
    assert fits.best.dof == 2
    assert json.loads(fits.to_json())["fits"][0]["aicc"] is None


def test_a_quantity_is_averaged_over_laws():
    v = np.linspace(0.1, 0.8, 30)
    mu = 0.5 - 0.2 * v + 0.01 * np.random.default_rng(6).normal(size=30)
    fits = ss.fit(v, mu, laws=["a - b*v", "a - b*v^2", "a - b*sqrt(v)"])
    averaged = fits.average(lambda law: ss.pure_slip_damping(law, V=0.5, N=9.81, method="harmonic"))
    weights, values, errors = np.array([(row.weight, row.value, row.standard_error) for row in averaged.rows]).T
    assert [row.law for row in averaged.rows] == [fit.name for fit in fits if fit.weight > 0.01 * fits[0].weight]
    assert averaged.value == pytest.approx(weights @ values / weights.sum())
    draws = np.random.default_rng(1)
    which = draws.choice(len(values), 200_000, p=weights / weights.sum())
    assert averaged.standard_error == pytest.approx(np.std(draws.normal(values[which], errors[which])), rel=0.02)
    assert averaged.standard_error > errors[0]
    shares = weights / weights.sum()
    noise = shares @ [fits[row.law].chi_squared / fits[row.law].dof for row in averaged.rows]
    for row in averaged.rows:
        law = fits[row.law]
        alone = ss.pure_slip_damping(law.law.bind(**law.uncertain), V=0.5, N=9.81, method="harmonic")
        wider = (noise / law.variance) ** 0.5  # the noise is one for all laws
        assert (row.value, row.standard_error) == pytest.approx((alone.value, wider * alone.uncertainty))


def test_many_rows_are_fitted_as_few():
    """To the same minimum as without bins, which the starts of many rows are taken from."""
    rng = np.random.default_rng(12)
    v = rng.uniform(0.001, 1.5, 20_000)
    mu = ss.laws.stribeck.typical().mu(v) + NOISE * rng.normal(size=20_000)
    best = ss.fit(v, mu, laws="stribeck").best
    for name, value in ss.laws.stribeck.typical().values.items():
        assert best.values[name] == pytest.approx(float(value), abs=4 * best.standard_errors[name])
    jump = ss.fit(v, np.where(v < 0.6217, 0.4, 0.3), NOISE, laws="Piecewise((a, v < w), (d, True))").best
    assert max(v[v < 0.6217]) < jump.values["w"] < min(v[v > 0.6217])


@st.composite
def few_rows(draw):
    """Rows of friction that is constant, none, straight, falling, random or along the motion, at any scale."""
    count = draw(st.sampled_from([3, 4, 6, 12, 40]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    share = rng.uniform(0, 1, count).round(draw(st.sampled_from([2, 16])))
    constant = np.full(count, 0.3)
    straight, falling = 0.5 - 0.1 * share, 0.2 + 0.3 * np.exp(-5 * share)
    mu = draw(st.sampled_from([constant, 0 * constant, straight, falling, rng.uniform(0, 1, count), -straight]))
    noise = draw(st.sampled_from([0, 0.01])) * rng.normal(size=count)
    return draw(st.sampled_from([1e-3, 1, 50])) * share, mu + noise


@given(few_rows(), st.sampled_from([None, 0.01, 1e-9, 10.0]), st.sampled_from(list(ss.laws)))
def test_any_rows_are_fitted_or_refused(rows, sigma, law):
    """And no number that is shown is none."""
    laws = sorted({law, "coulomb"})
    try:
        fits = ss.fit(*rows, sigma, laws=laws)
    except ss.InputError as error:
        assert str(error).startswith("no law could be fitted")  # noqa: PT017  # else there is a fit
        return
    assert {*fits.rejected, *(fit.name for fit in fits)} == {*laws}
    for text in (str(fits), fits.to_json(), *map(str, fits)):
        assert "nan" not in text.lower()


CURVE = ss.FrictionLaw.from_samples([0, 1, 2, 3], [0.5, 0.4, 0.3, 0.2])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1, 2],), "mu is missing"),
        ((Measurements.of([1, 2], [1, 1]), [1, 1]), "given twice"),
        (([1, 2], [1, 1], None, []), "there is no law to fit"),
        (([1, 2], [1, 1], None, ["linear", "linear"]), "the law linear is given twice"),
        (([1, 2], [1, 1], None, ss.laws.linear.typical()), "it has no parameter without a value"),
        ((*data(), None, CURVE), "goes through measured points, and has nothing to fit"),
        (([1, 2], [1]), r"v has the shape \(2,\) and mu \(1,\)"),
        (([-1, 2], [1, 1]), "v = -1 is below 0"),
        (([1, 2], [1, 7]), r"mu\[1\] = 7; a coefficient of friction is below 5"),
        (([1, 2], [1, 1], [0.1, 0]), "sigma = 0 is not above 0"),
        (([1, float("nan")], [1, 1]), "not finite"),
    ],
)
def test_what_cannot_be_fitted_is_refused(arguments, message):
    with pytest.raises(ss.InputError, match=message):
        ss.fit(*arguments)
