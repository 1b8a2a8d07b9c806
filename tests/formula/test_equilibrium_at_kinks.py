"""The equilibrium criterion at a kink of mu: every view has the mean of both slopes, by which motions decay."""

import random
import re

import mpmath
import pytest
import sympy as sp

import stickslip_sym as ss
from support.exported_code import runs, values_of
from support.sweeps import sample, sweep

V, N = 0.49, 3.0  # this speed times its rounded inverse is not 1
PIECES = ("a*v", "a*v^2", "a*exp(-b*v)", "a*tanh(b*v)", "a/(1 + b*v)", "a*sqrt(v)", "a/(b + 1 - v)")
KINKS = {
    "Piecewise(({l}, v < w), ({r}, True))": ("{l}", "{r}"),
    "{l} - h*Max(v - w, 0)": ("{l}", "{l} - h*(v - w)"),
    "{l} - h*abs(v - w)*exp(-v)": ("{l} + h*(v - w)*exp(-v)", "{l} - h*(v - w)*exp(-v)"),
    "{l} - h*Max(v - w, 0) + Piecewise((b*v, v < 2*w), (h, True))": ("{l} + b*v", "{l} - h*(v - w) + b*v"),
}
"""Laws with a kink at w, and their smooth pieces on both sides of it."""


def law_in_pieces(seed):
    """Return a law with a kink at V, and the two slopes there."""
    rng = random.Random(seed)
    left, right = (rng.choice(PIECES) for _ in range(2))
    values = {"a": rng.randint(1, 9) / 50, "b": rng.randint(1, 9) / 9, "h": rng.randint(1, 9) / 30, "w": V}
    kink = list(KINKS)[seed % len(KINKS)]

    def bound(text):
        law = ss.FrictionLaw("1.9 - v/10 - (" + text.format(l=left, r=right) + ")")
        return law.bind(**{name: value for name, value in values.items() if name in law.parameters})

    return bound(kink), [bound(side).slope(V) for side in KINKS[kink]]


def views(law, speed, folder):
    """Yield the damping at a belt speed as every view has it."""
    form, function = ss.derive(law, "equilibrium"), ss.slope_average(law, "equilibrium")
    yield "enclosure", float(ss.enclose(law, "equilibrium", V=speed, N=N))
    yield "quadrature", float(ss.quadrature.damping(law, "equilibrium", V=speed, N=N, digits=15))
    yield "threshold", ss.pure_slip_damping(law, V=speed, N=N, method="equilibrium").value
    yield "fast function", function(V=speed, N=N)
    yield "array", function(V=[2.0, speed, 0.1], N=N)[1]
    yield "call", form(V=speed, N=N)
    yield "digits", float(form.evaluate(20, V=speed, N=N))
    point = {"V": speed, "N": N, **{name: float(value) for name, value in law.values.items()}}
    exact = {symbol: sp.Rational(point[name]) for name, symbol in function.arguments.items()}
    yield "formula", float(form.expr.subs(exact))
    for language in filter(runs, ("python", "c")):
        text = function.code(language)
        names = re.search(r"damping\((.*?)\)", function.code("python"))[1].split(", ")
        yield language, float(values_of(language, text, [("damping", [point[name] for name in names])], folder)[0])


@sample(1)
@sweep("seed", range(4), 1, 3)
@mpmath.workdps(30)
def test_every_view_has_the_mean_of_both_slopes(seed, tmp_path):
    law, (left, right) = law_in_pieces(seed)
    for view, value in views(law, V, tmp_path):
        assert value == pytest.approx(-N * (left + right) / 2, rel=1e-13), view


@mpmath.workdps(30)
def test_beside_the_kink_every_view_has_the_slope_there(tmp_path):
    """A mean that is taken too widely would be noticed."""
    law, slopes = law_in_pieces(1)
    assert abs(slopes[0] - slopes[1]) > 0.01
    for slope, side in zip(slopes, (-1, 1), strict=True):
        for view, value in views(law, V * (1 + side * 1e-13), tmp_path):
            assert value == pytest.approx(-N * slope, rel=1e-11), view


def test_a_pole_beyond_the_kink_leaves_the_slope_before_it():
    law = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.3), (0.5 - 0.1/(2 - v), True))")
    assert ss.slope_average(law, "equilibrium")(V=[0.1, 0.4], N=1.0) == pytest.approx([0.1, 0.1 / 1.6**2])
