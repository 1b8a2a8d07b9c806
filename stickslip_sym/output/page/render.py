"""Pages from jinja2 templates: text escaped, numbers with all their digits, formulas as MathML.

A template extends ``page.html``, the frame that all pages share. A page is XML too, needs no script, and refers to
nothing elsewhere.
"""

import math
import platform
import re
from datetime import UTC, datetime
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.version import __version__
from stickslip_sym.output import printing
from stickslip_sym.output.markup import Markup, element, escaped, prose

if TYPE_CHECKING:
    from jinja2 import Environment

__all__ = [
    "equation",
    "formula",
    "now",
    "number",
    "percent",
    "render",
    "require_templates",
    "versions",
    "with_error",
]

_PACKAGES = ("sympy", "mpmath", "numpy", "scipy", "matplotlib")
_FRAME = Path(__file__).parent
_POWER = re.compile(r"e([+-])0*(\d+)$")
_MOST_DECIMALS = 9
_LARGE = 1e7  # from which a number is shown with a power of ten


def require_templates() -> None:
    """Refuse to write a page without jinja2 and latex2mathml."""
    try:
        import jinja2  # noqa: F401  # only to see that it is there
        import latex2mathml.converter  # noqa: F401
    except ImportError:
        raise InputError("pages need jinja2 and latex2mathml: pip install 'stickslip_sym[plot]'") from None


def render(template: Path, **values: Any) -> str:
    """Return a page.

    - `template`: its file; a file of the same name that ends in .css is its own style, after that of all pages.
    - `values`: what stands in it.

    Raises `InputError` if jinja2 or latex2mathml is not installed.
    """
    require_templates()
    style = template.with_suffix(".css")
    sheets = [_FRAME / "page.css", *([style] if style.is_file() else [])]
    values["style"] = Markup("".join(sheet.read_text(encoding="utf-8") for sheet in sheets))
    values["versions"] = versions("uncertainties")
    return _environment(template.parent).get_template(template.name).render(values)


@lru_cache(maxsize=8)
def _environment(folder: Path) -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    def clean(value: object) -> object:
        return value if hasattr(value, "__html__") else escaped_text(str(value))

    environment = Environment(
        loader=FileSystemLoader([folder, _FRAME]), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=StrictUndefined, finalize=clean, keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters |= {"number": number, "percent": percent, "prose": prose, "symbol": symbol}
    environment.filters |= {"with_error": with_error}
    environment.tests["finite"] = math.isfinite
    return environment


def escaped_text(text: str) -> Markup:
    """Return text as markup; what is no character of XML becomes a replacement character."""
    return Markup(escaped(text, quote=True))


def number(value: float | None, form: str = ".6g") -> Markup:
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


def percent(value: float | None, form: str = "+.3g") -> Markup:
    """Return a fraction in per cent; its exact value is the fraction."""
    if value is None or not math.isfinite(value):
        return element("span", "none")
    return element("data", f"{100 * value:{form}} %".replace("-", "−"), value=repr(float(value)))


def with_error(value: float, error: float | None) -> Markup:
    """Return a number with its standard error, both to two digits of that; alone if there is none."""
    if error is None or not error > 0 or not math.isfinite(error):
        return number(value)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    if decimals > _MOST_DECIMALS or max(abs(value), error) >= _LARGE:
        return Markup(f"{number(value)}\u00a0±\u00a0{number(error, '.2g')}")
    return Markup(f"{number(value, f'.{decimals}f')}\u00a0±\u00a0{number(error, f'.{decimals}f')}")


def formula(latex: str, *, block: bool = True) -> Markup:
    """Return LaTeX as an element ``math``.

    Raises `InputError` if latex2mathml is not installed.
    """
    require_templates()
    from latex2mathml.converter import convert

    return Markup(convert(latex, display="block" if block else "inline"))


def symbol(name: str) -> Markup:
    """Return the name of a quantity or parameter as a formula has it."""
    import sympy as sp

    return formula(printing.latex(sp.Symbol(name)), block=False)


def equation(left: Expr, right: Expr) -> Markup:
    """Return an equation of two expressions as an element ``math``."""
    return formula(f"{printing.latex(left)} = {printing.latex(right)}")


def versions(*more: str) -> dict[str, str]:
    """Return what computes here: Python, packages and more of them, as far as they are installed, the machine."""
    found = {"python": platform.python_version(), "stickslip_sym": __version__}
    for name in (*_PACKAGES, *more):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found | {"platform": platform.platform(), "machine": platform.machine()}


def now() -> str:
    """Return the time as pages tell it."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
