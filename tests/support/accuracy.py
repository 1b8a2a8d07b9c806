"""The error of a fast function against many digits, in units of epsilon N <|mu'|>."""

import random

import mpmath
import numpy as np
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.functions import write_sech
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.model.terms import speed_scales

EPSILON = 2.0**-52
EXPONENTS = ("delta",)
DIGITS = 30
"""Of differences from references, whatever mpmath's precision is: more than the references have."""

MOST_UNITS = 16  # for every law with a closed form
MOST_UNITS_OF_THE_PAPER = 4  # for the two laws of the paper
MOST_UNITS_BY_BALLS = 64  # near a confluent parameter

REGIMES = {"middle": (-4, 4), "small": (-40, -4), "large": (4, 100)}
"""Decades of the belt speed over the law's scale."""


def samples(law, regime, count, seed):
    """Draw operating points: parameters within a decade of typical, belt speeds log-uniform over the regime."""
    rng = random.Random(f"{law.name} {regime} {seed}")
    scales = [
        scale for scale in speed_scales(law.slope_expr, symbols.v) if scale.is_positive or not scale.is_number
    ]
    rows = []
    for _ in range(count):
        row = {}
        for name, parameter in law.parameters.items():
            width = 0.3 if name in EXPONENTS else 1
            row[name] = float(parameter.typical) * 10 ** rng.uniform(-width, width)
        point = {parameter.symbol: row[name] for name, parameter in law.parameters.items()}
        sizes = [float(abs(complex(scale.subs(point)))) for scale in scales] or [1.0]
        row["V"] = rng.choice(sizes) * 10 ** rng.uniform(*REGIMES[regime])
        row["N"] = 10 ** rng.uniform(-2, 2)
        rows.append(row)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def reference(form, columns):
    """Evaluate with 20 digits that 70 or more confirm."""
    count = len(columns["V"])
    return [
        form.evaluate(20, **{name: float(column[i]) for name, column in columns.items()}) for i in range(count)
    ]


LEVELS, POINTS = 200, 8  # panels of [0, 2V] that halve towards rest, and nodes in each


def mean_slope(form, columns):
    """Return N <|mu'|>, and at one point N max(|mu'|, |V mu''|): there the rounding of V itself counts."""
    law, v, s = form.law, symbols.v, symbols.s
    names = [name for name, parameter in law.parameters.items() if parameter.symbol in law.expr.free_symbols]
    arguments = [v, *(law.parameters[name].symbol for name in names)]
    rest = [columns[name][:, None] for name in names]
    slope = function_of(arguments, law.slope_expr, "numpy")
    V = columns["V"][:, None]
    with np.errstate(all="ignore"):
        if form.criterion.weight is None:
            curvature = function_of(arguments, write_sech(v * sp.diff(law.slope_expr, v)), "numpy")
            sizes = np.fmax(abs(slope(V, *rest)), abs(curvature(V, *rest))) + 0 * V
            return columns["N"] * np.nan_to_num(sizes[:, 0])
        x, w = np.polynomial.legendre.leggauss(POINTS)
        panels = 2.0 ** -np.arange(LEVELS)[:, None]
        p, weights = (panels * (x + 3) / 2).ravel(), (panels * w / 2).ravel()
        if form.criterion.is_polynomial:
            weights = weights * function_of([s], sp.expand(form.criterion.weight.subs(s, s - 1)), "numpy")(p)
        else:
            weights = weights * 2 / np.pi * np.sqrt(p * (2 - p))
        return columns["N"] * np.nansum(weights * np.abs(slope(V * p, *rest)) + 0 * V * p, axis=1)


def units(form, columns, values, exact=None):
    """Return the errors of values in units of epsilon N <|mu'|>."""
    exact = reference(form, columns) if exact is None else exact
    mean = mean_slope(form, columns)
    errors = []
    for value, right, size in zip(np.broadcast_to(values, mean.shape), exact, mean, strict=True):
        unit = max(float(abs(right)), float(size)) * EPSILON
        if not np.isfinite(value):
            errors.append(np.inf)
        elif unit < 2.0**-1022 * EPSILON:  # the truth is subnormal: a bit of it is all there is
            errors.append(0.0 if abs(value) <= 2.0**-1021 else np.inf)
        else:
            with mpmath.workdps(DIGITS):
                errors.append(float(abs(mpmath.mpf(float(value)) - right) / unit))
    return np.array(errors)


def by_definition(average, columns, digits=20):
    """Evaluate a slope average by an enclosure of its definition."""
    exact = []
    for i in range(len(columns["V"])):
        values = {name: float(column[i]) for name, column in columns.items()}
        V, N = values.pop("V"), values.pop("N")
        middle = ss.enclose(average.law.bind(**values), average.criterion, V=V, N=N, digits=digits).mid
        with mpmath.workdps(digits):
            exact.append(mpmath.mpf(middle.numerator) / middle.denominator)
    return exact
