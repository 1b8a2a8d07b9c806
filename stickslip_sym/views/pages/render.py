"""Pages from jinja2 templates: text escaped, numbers with all their digits, formulas as MathML.

A template extends ``page.html``, the frame that all pages share. A page is XML too, needs no script, and refers to
nothing elsewhere.
"""

import math
import platform
import re
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.version import __version__
from stickslip_sym.output import printing
from stickslip_sym.output.tables import TERMINAL_WIDTH
from stickslip_sym.views.markup import Markup, element, escaped, marked_prose

_PACKAGES = ("sympy", "mpmath", "numpy", "scipy", "matplotlib", "uncertainties")
_FRAME = Path(__file__).parent
_POWER = re.compile(r"(.*)e([+-])0*(\d+)")
MOST_SHOWN_DIGITS = 10  # of a value
_SHOWN_WITH_POWER = 1e7  # from which a number is shown with a power of ten


def require_templates() -> None:
    """Refuse to write a page without jinja2 and latex2mathml."""
    try:
        import jinja2  # noqa: F401  # only to see that it is there
        import latex2mathml.converter  # noqa: F401
    except ImportError:
        raise InputError("pages need jinja2 and latex2mathml: pip install jinja2 latex2mathml") from None


def render(template: Path, **values: Any) -> str:
    """Return a page.

    - `template`: its file; a file of the same name that ends in .css is its own style, after that of all pages.
    - `values`: what stands in it.

    Raises `InputError` if jinja2 or latex2mathml is not installed.
    """
    require_templates()
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader([template.parent, _FRAME]), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=StrictUndefined, keep_trailing_newline=True,
        finalize=lambda value: value if hasattr(value, "__html__") else Markup(escaped(str(value), quote=True)),
    )  # fmt: skip
    filters = {
        "number": number,
        "percent": percent,
        "prose": marked_prose,
        "symbol": symbol,
        "with_error": number_with_error,
    }
    environment.filters |= filters
    environment.tests["finite"] = math.isfinite
    sheets = [sheet for sheet in (_FRAME / "page.css", template.with_suffix(".css")) if sheet.is_file()]
    style = Markup("".join(sheet.read_text(encoding="utf-8") for sheet in sheets))
    page = environment.get_template(template.name)
    return page.render(values, style=style, versions=versions())


def heading(name: str) -> str:
    """Return a name as it stands in a heading: a long one is cut."""
    if len(name) <= TERMINAL_WIDTH:
        return name
    return f"{name[: TERMINAL_WIDTH - 1]}…"


def number(value: float | None, form: str = ".6g") -> Markup:
    """Return a number as an element ``data``, whose attribute has all its digits; without one the word none."""
    if value is None or not math.isfinite(value):
        return element("span", "none" if value is None or math.isnan(value) else "∞")
    text = format(float(value), form)
    exact = repr(float(value))
    if power := _POWER.fullmatch(text):
        exponent = element("sup", f"{power[2]}{power[3]}".replace("-", "−").removeprefix("+"))
        return element("data", f"{power[1]}·10".replace("-", "−"), exponent, value=exact)
    return element("data", text.replace("-", "−"), value=exact)


def percent(value: float | None, form: str = "+.3g") -> Markup:
    """Return a fraction in per cent; its exact value is the fraction."""
    if value is None or not math.isfinite(value):
        return element("span", "none")
    return element("data", f"{100 * value:{form}} %".replace("-", "−"), value=repr(float(value)))


def number_with_error(value: float, error: float | None) -> Markup:
    """Return a number with its standard error, both to two digits of that; alone if there is none."""
    if error is None or not error > 0 or not math.isfinite(error):
        return number(value)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > MOST_SHOWN_DIGITS or max(abs(value), error) >= _SHOWN_WITH_POWER:
        return Markup(f"{number(value)}\u00a0±\u00a0{number(error, '.2g')}")
    return Markup(f"{number(value, f'.{decimals}f')}\u00a0±\u00a0{number(error, f'.{decimals}f')}")


def math_element(latex: str, *, block: bool = True) -> Markup:
    """Return LaTeX as an element ``math``, or refuse it without latex2mathml."""
    require_templates()
    from latex2mathml.converter import convert

    return Markup(convert(latex, display="block" if block else "inline"))


def symbol(name: str) -> Markup:
    """Return the name of a quantity or parameter as a formula has it."""
    import sympy as sp

    return math_element(printing.latex(sp.Symbol(name)), block=False)


def mathml_equation(left: Expr, right: Expr) -> Markup:
    """Return an equation of two expressions as an element ``math``."""
    return math_element(f"{printing.latex(left)} = {printing.latex(right)}")


def versions() -> dict[str, str]:
    """Return what computes here: Python, packages as far as they are installed, the machine."""
    versions = {"python": platform.python_version(), "stickslip_sym": __version__}
    for name in _PACKAGES:
        with suppress(PackageNotFoundError):
            versions[name] = version(name)
    return versions | {"platform": platform.platform(), "machine": platform.machine()}
