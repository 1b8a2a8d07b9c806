"""An explorer in one file: a page with sliders for the operating point and the law, computed in the browser.

Criteria are their exported code, or for measured points a table over V; mu is the law's own formula. Motions are
integrated in the page. Exact thresholds cannot be computed there: they are a polynomial in log V and log N that is
made beforehand for the law's own parameters, and its error at other points is stated.
"""

import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputWarning, StickSlipError
from stickslip_sym.core.numbers import SAME
from stickslip_sym.criteria.criterion import Criterion, catalogue
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.code.languages import LANGUAGES
from stickslip_sym.formula.slope_average import slope_average
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.negative import warn_where_negative
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.averages import slope_mean
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output.markup import Markup
from stickslip_sym.output.page.render import now, render

_TEMPLATE = Path(__file__).with_name("explorer.html")
_SCRIPT = Path(__file__).with_name("explorer.js")
_RANGE = 5.0  # times a value, and its inverse, that a slider reaches
_DEGREES = 20, 8  # of the polynomial of exact thresholds, in log V and log N
_TRIED = 20  # other points at which it is held against exact thresholds
_RTOL = 1e-6  # of these
_ROWS = 500  # of a table of slope averages over log V
_SEED = 1785
_LONGEST_TITLE = 80  # characters


def explorer(law: FrictionLaw, osc: Oscillator, *, title: str = "", time_limit: float | None = None) -> str:
    """Return the page: HTML with its own script, which refers to nothing elsewhere.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound; sliders begin at these values.
    osc : Oscillator
    title : str
        By default the law's name, or its formula.
    time_limit : float, optional
        Seconds for the table of exact thresholds.

    Raises
    ------
    InputError
        If the law or a criterion cannot be written as JavaScript, or jinja2 is not installed.
    """
    warn_where_negative(law.kinetic, osc.V)
    law.require_speed(2 * osc.V)
    fixed = {str(symbol) for symbol in writer.shapes_of(law)}
    values = {name: float(value) for name, value in law.values.items()}
    sliders = {name: _slider(name, getattr(osc, name), symbols.QUANTITIES[name]) for name in "VNmk"}
    sliders |= {name: _slider(name, values[name], p) for name, p in law.parameters.items() if name not in fixed}
    if law.v_max is not None:
        sliders["V"]["high"] = min(sliders["V"]["high"], float(law.v_max) / 2)
    names = {symbols.v: "v"} | {p.symbol: f"p[{i}]" for i, p in enumerate(law.parameters.values())}
    formulas = {"mu": law.expr, "mu_static": law.static_expr, "slope": law.slope_expr}
    code = "".join(
        f"function {name}(v, p) {{\n  return {writer.text_of(expr, names, LANGUAGES['javascript'])};\n}}\n"
        for name, expr in formulas.items()
    )
    averages = {name: criterion for name, criterion in catalogue.items() if criterion.weight is not None}
    written = (
        {}
        if law.curve is not None
        else {name: slope_average(law, criterion) for name, criterion in averages.items()}
    )
    exact, reason = _exact(law, osc, sliders, time_limit)
    data = {
        "sliders": list(sliders.values()),
        "c": osc.c,
        "parameters": {name: values[name] for name in law.parameters},
        "criteria": {
            name: [key for key in average.arguments if key not in fixed] for name, average in written.items()
        },
        "tables": {
            name: _table(law, criterion, sliders["V"])
            for name, criterion in averages.items()
            if name not in written
        },
        "exact": exact,
    }
    if written:
        functions = {f"damping_{name}": (average, "") for name, average in written.items()}
        code = writer.code(functions, "javascript") + code
    else:
        code = LANGUAGES["javascript"].page["head"].replace("$about\n", "") + code
    own = title or law.name or law.text
    return render(
        _TEMPLATE,
        title=f"Stick–slip explorer: {own if len(own) <= _LONGEST_TITLE else f'{own[: _LONGEST_TITLE - 1]}…'}",
        law=law.text if law.curve is None else str(law.curve),
        reason=reason,
        error=exact and exact["error"],
        script=Markup(f"<script>\n{_harmless(code)}{_constant(data)}{_SCRIPT.read_text()}</script>"),
        time=now(),
    )


def _slider(name: str, value: float, described: Any) -> dict[str, Any]:
    """Return a slider that is logarithmic about a positive value, and else linear."""
    low, high = (value / _RANGE, value * _RANGE) if value > 0 else (value - 1.0, value + 1.0)
    unit = "" if described.unit in (None, "1") else described.unit
    return {"name": name, "value": value, "low": low, "high": high, "unit": unit, "meaning": described.meaning}


def _table(law: FrictionLaw, criterion: Criterion, slider: Mapping[str, Any]) -> list[float]:
    """Return c/N at even steps of log V, of a law that has no parameters."""
    V = np.geomspace(slider["low"], slider["high"] * (1 - SAME), _ROWS)
    return [float(mean) for mean in slope_mean(law.kinetic, criterion, V)]


def _exact(
    law: FrictionLaw, osc: Oscillator, sliders: Mapping[str, Mapping[str, Any]], time_limit: float | None
) -> tuple[dict[str, Any] | None, str]:
    """Return Chebyshev coefficients of c/N in log V and log N; None, and why, where some threshold is missing."""
    degrees = np.array(_DEGREES)
    x, y = (chebyshev.chebpts1(degree + 1) for degree in _DEGREES)
    points = np.stack([np.repeat(x, len(y)), np.tile(y, len(x))])
    tried = np.random.default_rng(_SEED).uniform(-1, 1, (2, _TRIED))
    ends = [np.log([sliders[name]["low"], sliders[name]["high"]]) for name in "VN"]

    def over_N(at: FloatArray) -> FloatArray:
        V, N = (np.exp(np.mean(both) + row * np.ptp(both) / 2) for both, row in zip(ends, at, strict=True))
        return np.asarray(pure_slip_damping(law, V=V, N=N, m=osc.m, k=osc.k, rtol=_RTOL).value / N)

    try:
        with deadline.time_limit(time_limit), warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)  # the page begins at the operating point, not there
            computed, held = over_N(points), over_N(tried)
    except StickSlipError as error:
        return None, str(error)
    columns = chebyshev.chebvander2d(points[0], points[1], _DEGREES)
    coefficients = np.linalg.lstsq(columns, computed, rcond=None)[0]
    misses = np.abs(chebyshev.chebvander2d(tried[0], tried[1], _DEGREES) @ coefficients - held)
    error_of_largest = float(np.max(misses) / np.max(np.abs(held)))
    return {"coefficients": coefficients.reshape(degrees + 1).tolist(), "error": error_of_largest}, ""


def _constant(data: Mapping[str, Any]) -> str:
    """Return data as a constant of the script, with no sign that would end it."""
    text = json.dumps(data, allow_nan=False)
    return f"const DATA = {text.replace('<', chr(92) + 'u003c')};\n"


def _harmless(code: str) -> str:
    """Return code in whose comments no words of a user end the script."""
    return code.replace("</", "< /").replace("<!--", "< !--")
