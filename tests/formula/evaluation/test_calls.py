"""Shapes and types of arguments, values that make no sense, and elements that know nothing of each other."""

import tracemalloc

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.formula.evaluation.term_function import TermFunction, _function_of_base
from stickslip_sym.formula.proof.gate import verify
from stickslip_sym.numerics.known import Unknown
from support.closed_forms import form_of
from support.sweeps import sweep

SAME = 8 * 2.0**-52  # an array multiplies in another order than a number does


@pytest.fixture(scope="module")
def form():
    return ss.derive(ss.laws.exponential.typical())


def test_every_argument_broadcasts(form):
    columns = {
        "V": np.linspace(0.1, 9, 6)[:, None, None], "N": np.array([1.0, 2.0])[:, None], "alpha": [1.0, 2.0, 3.0],
        "mu_s": np.full((6, 1, 3), 0.5), "mu_m": 0.2,
    }  # fmt: skip
    got = form(**columns)
    assert got.shape == (6, 2, 3)
    assert got[4, 1, 2] == pytest.approx(form(V=columns["V"][4, 0, 0], N=2.0, alpha=3.0), rel=SAME)


@pytest.mark.parametrize("dtype", ["f4", "f8", "i2", "i8", "u1", ">f8", "?"])
def test_types_in_float64_out(form, dtype):
    V = np.array([0.1, 1, 3]).astype(dtype)
    got = form(V=V, N=9)
    assert got.dtype == np.float64
    assert got == pytest.approx(form(V=V.astype(float), N=9.0), rel=SAME)


def test_memory_layouts(form):
    V = np.linspace(0.01, 9, 24).reshape(4, 6)
    expected = form(V=V, N=1.0)
    V.setflags(write=False)
    for other in (V, np.asfortranarray(V), np.repeat(V, 2, axis=1)[:, ::2], V[::-1, ::-1][::-1, ::-1]):
        assert np.array_equal(form(V=other, N=1.0), expected)


@pytest.mark.parametrize(
    ("V", "N", "shape"),
    [(np.empty((0, 3)), 1.0, (0, 3)), (np.empty(0), np.empty(0), (0,)), (np.array(0.5), 1.0, ()),
     (np.array([0.5]), 1.0, (1,)), (np.ones((1, 1)), 1, (1, 1)), ([0.5, 1], (1, 2), (2,))],
)  # fmt: skip
def test_empty_zero_dimensional_and_lists(form, V, N, shape):
    got = form(V=V, N=N)
    assert np.shape(got) == shape
    assert isinstance(got, float if shape == () else np.ndarray)


def test_nan_and_masks_propagate(form):
    got = form(V=[0.5, np.nan, 1.0], N=1.0)
    assert np.isnan(got).tolist() == [False, True, False]
    assert np.isnan(form(V=0.5, N=np.nan))
    masked = form(V=np.ma.array([0.5, -1.0, 1.0], mask=[False, True, False]), N=1.0)
    assert isinstance(masked, np.ma.MaskedArray)
    assert masked.mask.tolist() == [False, True, False]
    assert masked.compressed() == pytest.approx(form(V=[0.5, 1.0], N=1.0), rel=SAME)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"V": [0.5, -1.0]}, "V = -1 must not be negative"), ({"N": -1}, "N = -1 must not be negative"),
        ({"V": [np.inf]}, "V holds a value that is not finite"), ({"alpha": np.inf}, "alpha holds a value"),
        ({"mu_s": [-np.inf, 1]}, "mu_s holds a value"),
    ],
)  # fmt: skip
def test_invalid_values(form, wrong, message):
    values = {"V": 0.5, "N": 1.0} | wrong
    with pytest.raises(ss.InputError, match=message):
        form(**values)
    got = np.atleast_1d(form(**values, on_invalid="nan"))
    assert np.isnan(got).any()
    assert np.isfinite(got).sum() == got.size - 1
    with pytest.raises(ss.InputError, match="on_invalid = 'ignore' must be"):
        form(**values, on_invalid="ignore")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        *(({"V": value}, r"V = .* is not a number or an array of numbers")
          for value in (None, 10**400, np.datetime64("2020"))),
        ({"V": "fast"}, "V = 'fast' is not a number"),
        ({"mu_d": 0.3}, "'mu_d' is not an argument of this closed form"),
        ({"V": [1.0, 2.0], "N": [1.0, 2.0, 3.0]}, "the shapes do not broadcast"),
    ],
)  # fmt: skip
def test_what_is_no_argument_is_named(form, wrong, message):
    with pytest.raises(ss.InputError, match=message):
        form(**{"V": 0.5, "N": 1.0} | wrong)
    with pytest.raises(ss.InputError, match=r"no value for N; give N=\.\.\."):
        form(V=0.5)


def test_rest_gives_the_limit():
    for name in ("exponential", "polynomial"):
        law = ss.laws.catalogue[name].typical()
        form = ss.derive(law, "harmonic")
        assert form(V=[0.0, 1.0], N=2.0)[0] == pytest.approx(-2 * law.slope(0.0), rel=1e-15)
    for text in ("a*v + a*w*exp(-v/w)", "a*v - a*w*log(1 + v/w)"):  # of which balls tell that terms cancel
        assert ss.slope_average(text)(V=[0.0, 0.1], N=2.0, a=0.3, w=0.7)[0] == 0
    with pytest.raises(ss.InputError, match="infinite at v = 0"):
        form_of("stribeck", "least_squares")(V=0.0, N=1.0, mu_s=0.5, mu_m=0.2, v_s=1.0, delta=0.5)


def test_signs():
    cubic = form_of("cubic", "least_squares")
    values = dict.fromkeys(cubic.arguments, 1.0) | {"V": [0.5, 1.0], "a_1": -3.0}
    assert cubic(**values)[0] > 0
    constant = ss.slope_average("0.3")
    assert not np.signbit([*constant(V=[0.1, 0.2], N=1.0), constant(V=0.1, N=1.0)]).any()


def test_an_array_of_shapes_is_taken_apart():
    form = form_of("stribeck", "least_squares")
    delta = np.repeat([0.7, 1.5], 100)
    V = np.tile(np.logspace(-2, 1, 100), 2)
    rest = {"N": 1.0, "mu_s": 0.5, "mu_m": 0.2, "v_s": 0.5}
    got = form(V=V, delta=delta, **rest)
    for i in (3, 150):
        exact = form.evaluate(20, V=float(V[i]), delta=float(delta[i]), **rest)
        assert got[i] == pytest.approx(float(exact), rel=1e-12)


# -- blocks ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
@sweep("name", ["exponential", "polynomial", "gaussian", "hyperbolic", "arctangent", "rational", "logarithmic",
                "two_exponentials"], "exponential", "arctangent", "two_exponentials")  # fmt: skip
def test_neighbours_change_nothing(name, criterion):
    rng = np.random.default_rng(5)
    average = ss.slope_average(ss.laws.catalogue[name].typical(), criterion)
    for share in (0.02, 0.5, 0.98):  # of low speeds in a block
        V = np.where(rng.random(200) < share, 10 ** rng.uniform(-4, -1, 200), 10 ** rng.uniform(-0.5, 3, 200))
        assert average(V=V, N=9.81).tolist() == [average(V=float(one), N=9.81) for one in V]


def test_blocks_join_without_a_seam_and_in_little_memory():
    """Beyond the result a call takes a few arrays of one block."""
    rng = np.random.default_rng(3)
    average = ss.slope_average(ss.laws.exponential.typical())
    V, alpha = rng.uniform(0.01, 3, 400_000), rng.uniform(1, 6, 400_000)
    beyond = []
    for size in (200_000, 400_000):
        tracemalloc.start()
        together = average(V=V[:size], N=9.81, alpha=alpha[:size])
        beyond.append(tracemalloc.get_traced_memory()[1] - together.nbytes)
        tracemalloc.stop()
    assert beyond[1] < 1.1 * beyond[0] < 5e6
    for part in (slice(0, 7), slice(16_382, 16_387), slice(399_999, 400_001)):
        assert (together[part] == average(V=V[part], N=9.81, alpha=alpha[part])).all()
    assert not np.allclose(average(V=V[:9], N=9.81, alpha=alpha[9:18]), together[:9], rtol=1e-3)


def test_no_power_of_two_long_fractions_is_taken_apart(monkeypatch):
    """SymPy writes such a power by its prime factors: for these two floats, of a fit, by 3^4488928618064725."""
    taken_apart = sp.Integer._eval_power

    def guarded(number, exponent):
        if exponent.is_Rational and exponent.q > 2**20 and number > 2**20:
            raise AssertionError("a number without end is computed")
        return taken_apart(number, exponent)

    monkeypatch.setattr(sp.Integer, "_eval_power", guarded)
    measured = {"mu_s": 0.35, "mu_m": 0.15, "v_s": 0.25007783324531996, "delta": 1.0010858728217171}
    law = ss.laws.stribeck.bind(**measured)
    for criterion in ("least_squares", "harmonic"):
        average = ss.slope_average(law, criterion)
        by_balls = float(ss.enclose(law, criterion, V=0.5, N=9.81))
        assert average(V=0.5, N=9.81) == pytest.approx(by_balls, rel=SAME)
        assert average(V=0.5, N=9.81, mu_s=0.15) == 0  # mu is constant there


def test_branches_of_a_new_shape_are_made_from_the_eighth_value_on(monkeypatch):
    """A few values are had sooner by balls."""
    average, made = ss.slope_average("0.2 + 0.3*exp(-(v/0.5)^p)"), []

    def counted(self, shapes=()):
        made.append(shapes)
        return Unknown("they are counted here")

    monkeypatch.setattr(TermFunction, "branches", counted)
    for V in np.linspace(0.1, 0.7, 7).tolist():
        average(V=V, N=1.0, p=1.5)
    assert made == []
    average(V=0.8, N=1.0, p=1.5)
    assert made == [(1.5,)]


@pytest.mark.parametrize(("d", "kept"), [(0.9, True), (1.5, False)])
def test_a_sum_that_cancels_is_left_to_balls(d, kept):
    """1 + 1 - 0.9 is a third of the sizes of its terms, 1 + 1 - 1.5 a seventh."""
    symbols = sp.symbols("a b d", positive=True)
    value = _function_of_base(symbols[0] + symbols[1] - symbols[2], symbols)([1.0, 1.0, d])
    assert (value == 2 - d) if kept else np.isnan(value)


def test_the_gate_says_what_it_compared():
    v, V = ss.symbols.v, ss.symbols.V
    verdict = verify(v**2, ss.criteria.catalogue["least_squares"], -2 * V)
    assert verdict.evidence == "agrees with enclosures to 30 digits at 12 random points"


def test_a_wave_has_a_table_as_far_as_it_waves_seldom():
    wave = ss.slope_average("0.3 + 0.02*sin(v)", "harmonic").functions[0]
    assert not isinstance(wave.branches(), Unknown)
