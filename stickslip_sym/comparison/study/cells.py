"""Numbers and names as a study's page has them; the exact value of each number stands beside what is shown."""

import math
import re

import sympy as sp

from stickslip_sym.output.page.elements import Html, element, raw
from stickslip_sym.output.page.mathml import FormulaPrinter

__all__ = ["name", "number", "percent", "with_error"]

_POWER = re.compile(r"e([+-])0*(\d+)$")
_MOST_DECIMALS = 9
_LARGE = 1e7  # from which a number is shown with a power of ten


def number(value: float | None, form: str = ".6g") -> Html:
    """Return a number as an element ``data``, whose attribute has all its digits; without one the word none."""
    if value is None or not math.isfinite(value):
        return element("span", "none" if value is None or math.isnan(value) else "∞")
    text = format(float(value), form)
    power = _POWER.search(text)
    mantissa = (text if power is None else text[: power.start()]).replace("-", "−")
    if power is None:
        return element("data", mantissa, value=repr(float(value)))
    exponent = f"{'−' if power[1] == '-' else ''}{power[2]}"
    return element("data", f"{mantissa}·10", element("sup", exponent), value=repr(float(value)))


def percent(value: float | None, form: str = "+.3g") -> Html:
    """Return a fraction in per cent; its exact value is the fraction."""
    if value is None or not math.isfinite(value):
        return element("span", "none")
    return element("data", f"{100 * value:{form}} %".replace("-", "−"), value=repr(float(value)))


def with_error(value: float, error: float | None) -> Html:
    """Return a number with its standard error, both to two digits of that; alone if there is none."""
    if error is None or not error > 0 or not math.isfinite(error):
        return number(value)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > _MOST_DECIMALS or max(abs(value), error) >= _LARGE:
        return raw(f"{number(value)} ± {number(error, '.2g')}")
    return raw(f"{number(value, f'.{decimals}f')} ± {number(error, f'.{decimals}f')}")


def name(text: str) -> Html:
    """Return the name of a quantity or parameter as a formula has it."""
    symbol = raw(FormulaPrinter().doprint(sp.Symbol(text)))
    return element("math", symbol, xmlns="http://www.w3.org/1998/Math/MathML")
