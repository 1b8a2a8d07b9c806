"""Shapes and types of arguments, and what becomes of values that make no sense."""

import numpy as np
import pytest
from forms import form_of

import stickslip_sym as ss

SAME = 4 * 2.0**-52  # an array multiplies in another order than a number does


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
    V = np.array([1, 1, 3]).astype(dtype)
    got = form(V=V, N=9)
    assert got.dtype == np.float64
    assert got == pytest.approx(form(V=V.astype(float), N=9.0), rel=SAME)


def test_float32_is_computed_in_float64(form):
    V = np.float32(0.1)
    assert form(V=V, N=1.0) == pytest.approx(form(V=float(V), N=1.0), rel=SAME)


def test_memory_layouts(form):
    V = np.linspace(0.01, 9, 24).reshape(4, 6)
    expected = form(V=V, N=1.0)
    read_only = V.copy()
    read_only.setflags(write=False)
    for other in (np.asfortranarray(V), read_only, np.repeat(V, 2, axis=1)[:, ::2]):
        assert np.array_equal(form(V=other, N=1.0), expected)
    assert np.array_equal(form(V=V[::-1, ::2], N=1.0), expected[::-1, ::2])


def test_empty_zero_dimensional_and_lists(form):
    assert form(V=np.empty((0, 3)), N=1.0).shape == (0, 3)
    assert form(V=np.empty(0), N=np.empty(0)).shape == (0,)
    assert isinstance(form(V=np.array(0.5), N=1.0), float)
    assert form(V=np.array([0.5]), N=1.0).shape == (1,)
    assert form(V=np.ones((1, 1)), N=1).shape == (1, 1)
    assert form(V=[0.5, 1], N=(1, 2)).shape == (2,)


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


def test_on_invalid_is_one_of_two_words(form):
    with pytest.raises(ss.InputError, match="on_invalid = 'ignore' must be"):
        form(V=0.5, N=1.0, on_invalid="ignore")


def test_rest_gives_the_limit():
    for name in ("exponential", "polynomial"):
        law = ss.laws.catalogue[name].typical()
        form = ss.derive(law, "harmonic")
        assert form(V=[0.0, 1.0], N=2.0)[0] == pytest.approx(-2 * law.slope(0.0), rel=1e-15)
    with pytest.raises(ss.InputError, match="infinite at v = 0"):
        form_of("stribeck", "least_squares")(V=0.0, N=1.0, mu_s=0.5, mu_m=0.2, v_s=1.0, delta=0.5)


def test_negative_values_of_parameters_that_may_be():
    cubic = form_of("cubic", "least_squares")
    values = dict.fromkeys(cubic.arguments, 1.0) | {"V": [0.5, 1.0], "a_1": -3.0}
    assert cubic(**values)[0] > 0


def test_blocks_agree_with_one_by_one(form):
    rng = np.random.default_rng(3)
    V = 10 ** rng.uniform(-3, 3, 50_001)
    got = form(V=V, N=9.81)
    chosen = rng.integers(0, V.size, 50)
    assert got[chosen] == pytest.approx([form(V=float(v), N=9.81) for v in V[chosen]], rel=2 * SAME)


def test_an_array_of_shapes_is_taken_apart():
    form = form_of("stribeck", "least_squares")
    delta = np.repeat([0.7, 1.5], 100)
    V = np.tile(np.logspace(-2, 1, 100), 2)
    rest = {"N": 1.0, "mu_s": 0.5, "mu_m": 0.2, "v_s": 0.5}
    got = form(V=V, delta=delta, **rest)
    for i in (3, 150):
        exact = form.evaluate(20, V=float(V[i]), delta=float(delta[i]), **rest)
        assert got[i] == pytest.approx(float(exact), rel=1e-12)


@pytest.mark.parametrize("value", [None, 10**400, np.datetime64("2020"), "fast"])
def test_what_is_no_number_is_named(value):
    with pytest.raises(ss.InputError, match=r"V = .* is not a number or an array of numbers"):
        ss.slope_average(ss.laws.exponential.typical())(V=value, N=1.0)
