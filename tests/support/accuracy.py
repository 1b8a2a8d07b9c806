"""The error of a fast function against many digits, in units of epsilon N <|mu'|>."""

import ctypes
import random
import subprocess

import mpmath
import numpy as np

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria import gauss
from stickslip_sym.formula.evaluation.bounds import slope_with_bound
from stickslip_sym.formula.evaluation.conditioning import conditioned, speed_scales

EPSILON = 2.0**-52
EXPONENTS = ("delta",)

MOST_UNITS = 16  # for every law with a closed form
MOST_UNITS_OF_THE_PAPER = 4  # for the two laws of the paper
MOST_UNITS_BY_GAUSS = 64  # for laws without a closed form, and near a confluent parameter

REGIMES = {"middle": (-4, 4), "small": (-40, -4), "large": (4, 100)}
"""Decades of the belt speed over the law's scale."""


def samples(law, regime, count, seed):
    """Draw scenes: parameters a decade to either side of typical, belt speeds log-uniform over the regime."""
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


def mean_slope(form, columns):
    """Return N <|mu'|> in double precision; 0 where Gauss rules do not reach."""
    law = form.law
    if form.criterion.weight is None:
        return np.zeros_like(columns["V"])  # the unit is the value's own size
    names = list(law.parameters)
    slope = conditioned(law.slope_expr)
    compiled = slope_with_bound(slope, [symbols.v, *(law.parameters[name].symbol for name in names)])
    rest = [columns[name] for name in names]
    scale = columns["V"].copy()
    for found in speed_scales(slope, symbols.v):
        with np.errstate(all="ignore"):
            size = function_of([law.parameters[name].symbol for name in names], found, "numpy")(*rest)
        scale = np.where(np.isfinite(size), np.minimum(scale, size), scale)
    _, size, _ = gauss.average(compiled, columns["V"], rest, form.criterion, scale=scale)
    return np.where(np.isfinite(size), columns["N"] * size, 0)


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
            errors.append(float(abs(mpmath.mpf(float(value)) - right) / unit))
    return np.array(errors)


def form_of(name, criterion):
    """Derive a closed form by rules alone; None where there is none."""
    try:
        return ss.derive(ss.laws.catalogue[name], criterion, search=False)
    except ss.NoClosedForm:
        return None


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


def compiled(text, directory, count):
    """Compile C99 without a word of warning, and return its function."""
    (directory / "damping.c").write_text(text)
    strict = ["-std=c99", "-pedantic", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
    command = ["gcc", *strict, "-shared", "-fPIC", "damping.c", "-o", "damping.so", "-lm"]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    function = ctypes.CDLL(str(directory / "damping.so")).damping
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * count
    return function
