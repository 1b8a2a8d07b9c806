"""An explorer in one file: a page with sliders for the operating point and the law, computed in the browser.

Criteria are their exported code, or for measured points a table over V; mu is the law's own formula. The
threshold is computed in the page as well: it follows the slip that begins where a stick phase ends, for what the
sliders say.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp
from uncertainties import UFloat, covariance_matrix

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import Expr, Json
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import row
from stickslip_sym.core.numbers import SAME
from stickslip_sym.criteria.criterion import Criterion, catalogue
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.code.languages import LANGUAGES
from stickslip_sym.formula.evaluation.term_sum import TermSum
from stickslip_sym.formula.slope_average import slope_average
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.pieces import places
from stickslip_sym.model.expression.slope import slope_of
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.negative import warn_where_negative
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.averages import resolved_gauss_average
from stickslip_sym.output.tables import now
from stickslip_sym.views.drawing import MOST_DRAWN
from stickslip_sym.views.markup import Markup
from stickslip_sym.views.pages.render import heading, render

_TEMPLATE = Path(__file__).with_name("explorer.html")
_SCRIPTS = [Path(__file__).with_name(name) for name in ("slip.js", "explorer.js")]
_RANGE = 5.0  # times a value, and its inverse, that a slider reaches
_TABLE_ROWS = 500  # of a table of slope averages over log V
_SIGNS = {"V": "positive", "N": "nonnegative", "m": "positive", "k": "positive"}
"""What Python requires of the operating point."""


def explorer(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    title: str = "",
    errors: Mapping[str, UFloat] | None = None,
    measured: Measurements | None = None,
    time_limit: float | None = None,
) -> str:
    """Return the page: HTML with its own script, which refers to nothing elsewhere.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound; sliders begin at these values, and their standard errors give the threshold one.
    osc : Oscillator
    title : str
        By default the law's name, or its formula.
    errors : mapping of str to number with a standard error, optional
        Of V, N, m and k.
    measured : Measurements, optional
        Points that are drawn beside the law.
    time_limit : float, optional
        Seconds for the branches of the criteria.

    Raises
    ------
    InputError
        If the law cannot be written as JavaScript, or jinja2 is not installed.
    OutOfTime
        If the criteria are not written within the time limit.
    """
    warn_where_negative(law.kinetic, osc.V)
    law.require_speed(2 * osc.V)
    fixed = {str(symbol) for symbol in writer.shapes_in_code(law)}
    values = {name: float(value) for name, value in law.values.items()}
    moved = {name: parameter for name, parameter in law.parameters.items() if name not in fixed}
    sliders = [_slider_of_quantity(name, getattr(osc, name)) for name in _SIGNS]
    sliders += [_slider_of_parameter(parameter, values[name]) for name, parameter in moved.items()]
    if law.v_max is not None:
        sliders[0]["most"] = float(law.v_max) / 2
        sliders[0]["high"] = min(sliders[0]["high"], sliders[0]["most"])

    averages = {name: criterion for name, criterion in catalogue.items() if criterion.weight is not None}
    written: dict[str, TermSum] = {}
    tables: dict[str, list[float]] = {}
    missing: dict[str, str] = {}
    with deadline.time_limit(time_limit):
        for name, criterion in averages.items():
            if law.curve is not None:
                tables[name] = _table(law, criterion, sliders[0])
                continue
            try:
                written[name] = _writable(slope_average(law, criterion))
            except InputError as refusal:
                missing[name] = str(refusal)

    uncertain = {
        name: value
        for name, value in {**law.uncertain, **(errors or {})}.items()
        if name in _SIGNS or name in moved
    }
    data = {
        "sliders": sliders,
        "c": osc.c,
        "parameters": {name: values[name] for name in law.parameters},
        "criteria": {
            name: [key for key in average.arguments if key not in fixed] for name, average in written.items()
        },
        "tables": tables,
        "covariance": {"names": list(uncertain), "matrix": covariance_matrix(list(uncertain.values()))},
        "measured": _points(measured),
    }
    if written:
        functions = {f"damping_{name}": (average, "") for name, average in written.items()}
        criteria_code = writer.code(functions, "javascript")
    else:
        criteria_code = LANGUAGES["javascript"].page["head"].replace("$about\n", "")
    page_script = "".join(script.read_text(encoding="utf-8") for script in _SCRIPTS)
    return render(
        _TEMPLATE,
        title=f"Stick–slip explorer: {heading(title or law.name or law.text)}",
        law=law.text if law.curve is None else str(law.curve),
        missing=missing,
        uncertain=", ".join(uncertain),
        banded=any(name in moved for name in uncertain),
        measured=measured is not None,
        script=Markup(
            f"<script>\n{_harmless(criteria_code + _law_code(law))}{_constant(data)}{page_script}</script>"
        ),
        time=now(),
    )


def _writable(average: TermSum) -> TermSum:
    """Return a criterion, or refuse one that cannot be written as JavaScript."""
    writer.code({"damping": (average, "")}, "javascript")
    return average


def _slider(name: str, value: float, unit: str | None, meaning: str, sign: str) -> Json:
    """Return a slider that is logarithmic about a positive value, and else linear."""
    low, high = (value / _RANGE, value * _RANGE) if value > 0 else (value - 1.0, value + 1.0)
    if sign and value == 0:
        low = 0.0
    shown_unit = "" if unit in (None, "1") else unit
    return {
        "name": name,
        "value": value,
        "low": low,
        "high": high,
        "unit": shown_unit,
        "meaning": meaning,
        "sign": sign,
    }


def _slider_of_quantity(name: str, value: float) -> Json:
    quantity = symbols.QUANTITIES[name]
    return _slider(name, value, quantity.unit, quantity.meaning, _SIGNS[name])


def _slider_of_parameter(parameter: Parameter, value: float) -> Json:
    sign = "nonnegative" if parameter.positive else ""
    return _slider(parameter.name, value, parameter.unit, parameter.meaning, sign)


def _table(law: FrictionLaw, criterion: Criterion, slider: Mapping[str, Any]) -> list[float]:
    """Return c/N at even steps of log V, of a law that has no parameters."""
    V = np.geomspace(slider["low"], slider["high"] * (1 - SAME), _TABLE_ROWS)
    return [float(mean) for mean in resolved_gauss_average(law.kinetic, criterion, V)]


def _points(measured: Measurements | None) -> list[list[float]]:
    """Return measured slip speeds and coefficients, evenly thinned where they are very many."""
    if measured is None:
        return [[], []]
    v = np.asarray(measured.v, np.float64)
    mu = np.asarray(measured.mu, np.float64)
    every = -(-len(v) // MOST_DRAWN)
    return [v[::every].tolist(), mu[::every].tolist()]


# -- the law as JavaScript ---------------------------------------------------------------------------


def _law_code(law: FrictionLaw) -> str:
    """Return mu, its slope, its static value, and where it varies quickly: functions of v and the parameters."""
    names = {symbols.v: "v"} | {p.symbol: f"p[{i}]" for i, p in enumerate(law.parameters.values())}

    def text(expr: Expr) -> str:
        return writer.expression_text(expr, names, LANGUAGES["javascript"])

    formulas = {"mu": law.expr, "mu_static": law.static_expr, "slope": law.slope_expr}
    functions = [f"function {name}(v, p) {{\n  return {text(expr)};\n}}\n" for name, expr in formulas.items()]
    kinks = ", ".join(text(place) for place in places(law.expr))
    functions.append(f"function kinks(p) {{\n  return [{kinks}];\n}}\n")
    # The pieces of a measured curve meet with the same slope: the error of a step sees such a place.
    functions.append(f"const SLOPES_MEET = {'true' if law.curve is not None else 'false'};\n")
    inner = [
        f"{{value: (v, p) => {text(expr)}, slope: (v, p) => {text(slope_of(expr))}, is_base: {is_base}}}"
        for expr, is_base in _inner_functions(law)
    ]
    functions.append(f"const inner_functions = [{', '.join(inner)}];\n")
    return "".join(functions)


def _inner_functions(law: FrictionLaw) -> Iterator[tuple[Expr, str]]:
    """Yield what stands in functions, and the bases of powers: near their zeros and turning points mu varies.

    The text says in JavaScript whether it is a base, which changes over its own size; an argument changes over 1.
    """
    if law.curve is not None:
        return
    seen: set[Expr] = set()
    for node in sp.preorder_traversal(law.expr):
        if node.is_Pow and not (node.exp.is_Integer and node.exp > 0):
            found = [(node.base, "true")]
        elif isinstance(node, sp.log):
            found = [(node.args[0], "true")]
        elif row(node) is not None and not isinstance(node, sp.Piecewise | sp.Min | sp.Max):
            found = [(part, "false") for part in node.args]
        else:
            continue
        for inner, is_base in found:
            if inner.has(symbols.v) and inner != symbols.v and inner not in seen:
                seen.add(inner)
                yield inner, is_base


def _constant(data: Mapping[str, Any]) -> str:
    """Return data as a constant of the script, with no sign that would end it."""
    text = json.dumps(data, allow_nan=False)
    return f"const DATA = {text.replace('<', chr(92) + 'u003c')};\n"


def _harmless(code: str) -> str:
    """Return code in whose comments no words of a user end the script."""
    return code.replace("</", "< /").replace("<!--", "< !--")
