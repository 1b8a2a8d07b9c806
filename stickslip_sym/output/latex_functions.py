r"""What functions and constants are called in LaTeX, and what they are called where a symbol has that name.

Beside a parameter ``eta``, ``\eta (1 + v)`` could be Dirichlet's function of 1 + v as well as a product.
"""

from collections.abc import Collection
from typing import TypeAlias

import sympy as sp

from stickslip_sym.core.lerch import Lerch
from stickslip_sym.output.notation import look

__all__ = ["INDEXED", "NAMED", "SQUARED", "called"]

Head: TypeAlias = "type[sp.Function] | sp.NumberSymbol"
"""What a function or a constant is to SymPy."""
NAMED: dict[Head, str] = {
    sp.log: r"\ln", sp.sin: r"\sin", sp.cos: r"\cos", sp.tan: r"\tan", sp.atan: r"\arctan",
    sp.sinh: r"\sinh", sp.cosh: r"\cosh", sp.tanh: r"\tanh", sp.coth: r"\coth",
    **{function: f"\\operatorname{{{name}}}" for function, name in (
        (sp.sech, "sech"), (sp.asinh, "arsinh"), (sp.acosh, "arcosh"), (sp.atanh, "artanh"), (sp.erf, "erf"),
        (sp.erfc, "erfc"), (sp.erfi, "erfi"), (sp.im, "Im"), (sp.re, "Re"), (sp.sign, "sgn"),
    )},
    sp.lowergamma: r"\gamma", sp.uppergamma: r"\Gamma", sp.gamma: r"\Gamma", sp.dirichlet_eta: r"\eta",
    sp.zeta: r"\zeta", sp.elliptic_k: "K", sp.elliptic_e: "E", sp.elliptic_pi: r"\Pi", Lerch: r"\Phi",
}  # fmt: skip
"""What an applied function is called; its arguments follow in parentheses."""
INDEXED: dict[Head, str] = {
    sp.besseli: "I", sp.besselj: "J", sp.besselk: "K", sp.bessely: "Y", sp.polylog: r"\operatorname{Li}",
}  # fmt: skip
"""Functions whose first argument is an index."""
SQUARED = (sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech)
"""Functions whose powers are written on their names."""
_CONSTANTS: dict[Head, str] = {sp.Catalan: "G", sp.pi: r"\pi", sp.EulerGamma: r"\gamma"}


def called(kind: Head, taken: Collection[str]) -> str:
    """Return the name of a function or a constant.

    - `kind`: a key of `NAMED` or `INDEXED`, or a constant.
    - `taken`: what the symbols beside it look like (`notation.look`).
    """
    name = NAMED.get(kind) or INDEXED.get(kind) or _CONSTANTS[kind]
    # K_1 is not K, but a symbol K_1 looks like the function with the index 1.
    others = {other.partition("_")[0] for other in taken} if kind in INDEXED else taken
    word = (kind.__name__ if isinstance(kind, type) else str(kind)).replace("_", "")
    choices = (name, f"\\operatorname{{{word}}}")
    return next((choice for choice in choices if look(choice) not in others), f"\\operatorname{{sympy.{word}}}")
