"""Laws with a step, a bump, a layer, a kink or a jump, narrow and anywhere, drawn at random."""

import numpy as np

import stickslip_sym as ss

SHAPES = {
    "step": "{h}*tanh({u})", "logistic": "{h}/(1 + exp(-({u})))", "arctangent": "{h}*atan({u})",
    "erf": "{h}*erf({u})",
    "bump": "{h}*exp(-({u})^2)", "lorentzian": "{h}/(1 + ({u})^2)", "sech": "{h}*sech({u})",
    "layer": "{h}*exp(-v/{w})", "kink": "{h}*Max(v - {a}, 0)",
    "logarithmic bump": "{h}*exp(-(log(v/{a})*{a}/{w})^2)", "logarithmic sech": "{h}*sech(log(v/{a})*{a}/{w})",
    "jump": "Piecewise((0, v < {a}), ({h}, True))", "nested": "{h}*tanh((exp(v/{a}) - exp(1))*{a}/{w})",
}  # fmt: skip
"""Of height h, at the slip speed a, with the width w, and u = (v - a)/w."""


def narrow_law(shape, seed):
    """Return a law, a belt speed within twice of which it is narrow, and the relative width, from 1e-8 to 1e-1."""
    random = np.random.default_rng(seed)
    V = 10.0 ** random.uniform(-2, 1)
    a = V * random.uniform(0.1, 1.9)
    relative = 10.0 ** random.uniform(-8, -1)
    h = random.choice([-1, 1]) * 10.0 ** random.uniform(-2.5, -1.5)
    a, w, h = (np.format_float_positional(x) for x in (a, relative * a, h))
    term = SHAPES[shape].format(a=a, w=w, h=f"({h})", u=f"(v - {a})/{w}")
    return ss.FrictionLaw(f"0.2 + 0.3*exp(-v/{V:.6f}) + {term}"), V, relative
