"""Hypothesis strategies for laws with values and for operating points: of the catalogue, random, in pieces."""

import warnings
from random import Random

from hypothesis import strategies as st

import stickslip_sym as ss
from support.closed_forms import LAWS

_SMOOTH = ("exp(-{0})", "1/(1 + {0})", "log(1 + {0})", "tanh({0})", "atan({0})", "asinh({0})", "sech({0})",
           "exp(-({0})^2)", "sqrt(1 + {0})", "1/(1 + ({0})^2)")  # fmt: skip
_INNER = (*_SMOOTH, "erf({0})", "sin({0})", "({0})^1.7", "({0})^2/(1 + {0})")
_OUTER = ("sqrt(0.1 + {1}*({0})^2)", "(1 + {1}*({0})^2)^(-0.7)", "1/(1 + {1}*({0})^2)", "exp(-{1}*({0}))",
          "log(1 + {1}*({0})^2)", "tanh({1}*({0}))", "atan(1 - {1}*({0}))", "({1} + ({0})^2)^(1/3)")  # fmt: skip
_KINKED = ("Abs({0} - 1)", "Min({0}, 1)", "Max({0} - 0.5, 0)", "Piecewise((0, v < {1}), {0} - v/{1})")


def _number(low: float, high: float) -> st.SearchStrategy[str]:
    """Decimals of up to 17 digits, as people and fits give them."""
    digits = st.integers(1, 17)
    return st.builds(lambda x, n: f"{x:.{n}g}", st.floats(low, high), digits)


def nested(rng: Random) -> ss.FrictionLaw:
    """A law of functions within functions, whose balls are wide where those of a catalogue law are not."""
    formula = rng.choice(_INNER).format(f"v/{10 ** rng.uniform(-2, 0.5):.3g}")
    for _ in range(rng.choice((1, 1, 2))):
        formula = rng.choice(_OUTER).format(formula, f"{10 ** rng.uniform(-1.5, 1.5):.3g}")
    return ss.FrictionLaw(f"0.3 + 0.2*{formula}")


@st.composite
def formulas(draw: st.DrawFn, *, kinks: bool = True, terms: int = 3) -> str:
    """Formulas in v with numbers only: a level and up to so many falling or rising terms."""
    shapes = [*_SMOOTH, *(_KINKED if kinks else ())]
    parts = []
    for _ in range(draw(st.integers(1, terms))):
        scale = draw(_number(0.05, 2.0))
        profile = draw(st.sampled_from(shapes)).format(f"v/{scale}", scale)
        parts.append(f"{draw(_number(0.01, 0.4))}*{profile}")
    signs = draw(st.lists(st.sampled_from("+-"), min_size=len(parts), max_size=len(parts)))
    return "0.5" + "".join(f" {sign} {part}" for sign, part in zip(signs, parts, strict=True))


@st.composite
def laws(draw: st.DrawFn, *, kinks: bool = True, static: bool = False) -> ss.FrictionLaw:
    """Laws with all their values: of the catalogue by random values, or a random formula.

    Parameters
    ----------
    kinks : bool
        Whether a law may have kinks.
    static : bool
        Whether a law may have a static coefficient above mu(0+).
    """
    if draw(st.booleans()):
        law = ss.laws[draw(st.sampled_from(LAWS))]
        factors = {name: draw(_number(0.5, 2.0)) for name in law.parameters}
        law = law.bind(
            **{name: f"{float(p.typical) * float(factors[name]):.17g}" for name, p in law.parameters.items()}
        )
    else:
        with warnings.catch_warnings(action="ignore", category=ss.InputWarning):
            law = ss.FrictionLaw(draw(formulas(kinks=kinks)))
    if static and draw(st.booleans()):
        law = law.with_static(str(round(law.onset * (1 + float(draw(_number(0.01, 0.5)))), 6)))
    return law


@st.composite
def operating_points(draw: st.DrawFn, *, weak: bool = False) -> ss.Oscillator:
    """Oscillators without damping: V, N, m and k over two decades each, N/(V sqrt(k m)) below 1 if `weak`."""

    def positive(low: float, high: float) -> float:
        return 10 ** draw(st.floats(low, high))

    V, m, k = positive(-1.5, 0.5), positive(-1, 1), positive(1, 3)
    eta = positive(-2, 0) if weak else positive(-2, 1)
    return ss.Oscillator(V=V, N=eta * V * (k * m) ** 0.5, m=m, k=k)
