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
LAYER = (0.1, 0.3, 1, 2, 4, 8, 16, 32)
"""Widths from rest, between which a layer is followed."""
DISTANCES = (0, 0.5, 1, 2, 3, *(4.0 * 2**i for i in range(60)))


def narrow_law(shape, seed):
    """Return a law, a belt speed within twice of which it is narrow, and the relative width, from 1e-8 to 1e-1."""
    plain, term, V, _, relative, _ = _drawn(shape, seed)
    return ss.FrictionLaw(f"{plain} + {term}"), V, relative


def parted(shape, seed):
    """Return mu(V w) - mu(0) of the same law in parts, and the w between them: beside its place, ever wider."""
    plain, term, V, place, relative, height = _drawn(shape, seed)
    law = ss.FrictionLaw(plain if shape == "jump" else f"{plain} + {term}")
    mu = law.function("numpy")

    def rise(w):
        with np.errstate(all="ignore"):  # where a layer has come to its end
            return float(mu(np.float64(V * abs(w))) - mu(np.float64(0.0)))

    w, width = place / V, relative * place / V
    if shape == "jump":
        return [rise, lambda w: rise(w) + height], [w]
    if shape == "kink":
        edges = [w]
    elif shape == "layer":
        edges = [width * x for x in LAYER]
    else:
        distances = [x * width for x in DISTANCES if x * width < w / 2]
        edges = sorted({w + side * x for x in distances for side in (-1, 1)})
    return [rise] * (len(edges) + 1), edges


def _drawn(shape, seed):
    """Return a plain law and what is narrow, a belt speed, the place, its relative width, and the height."""
    random = np.random.default_rng(seed)
    V = 10.0 ** random.uniform(-2, 1)
    place = V * random.uniform(0.1, 1.9)
    relative = 10.0 ** random.uniform(-8, -1)
    height = random.choice([-1, 1]) * 10.0 ** random.uniform(-2.5, -1.5)
    a, w, h = (np.format_float_positional(x) for x in (place, relative * place, height))
    term = SHAPES[shape].format(a=a, w=w, h=f"({h})", u=f"(v - {a})/{w}")
    return f"0.2 + 0.3*exp(-v/{V:.6f})", term, V, place, relative, height
