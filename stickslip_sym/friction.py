"""`FrictionLaw`: one expression mu(v) of the slip speed, its parameters and its source."""

import keyword
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym import printing, symbols
from stickslip_sym.codegen import function_of
from stickslip_sym.errors import InputError
from stickslip_sym.parsing import FUNCTIONS, NAME, parse_expression
from stickslip_sym.units import parse_unit
from stickslip_sym.values import Number, exact, exact_values, suggestion

__all__ = ["FrictionLaw", "Parameter"]


class Parameter:
    """A parameter of a friction law.

    Parameters
    ----------
    name : str
        A letter, then letters, digits or underscores.
    meaning : str
        What it is, in a few words.
    unit : str, optional
        SI unit as text, "1" for a pure number.
    typical : str, optional
        A value to try the law with, as decimal text (kept exact).
    positive : bool
        Whether the parameter is never negative. Formulas are simplified under this assumption, so
        values that break it are refused.
    """

    def __init__(
        self,
        name: str,
        meaning: str = "",
        unit: str | None = None,
        typical: str | None = None,
        positive: bool = True,
    ) -> None:
        _check_name(name)
        self.name = name
        self.meaning = meaning
        self.unit = unit
        self.typical = typical
        self.positive = positive
        self.symbol = sp.Symbol(name, positive=True) if positive else sp.Symbol(name, real=True)
        if unit is not None:
            parse_unit(unit)

    def __repr__(self) -> str:
        return f"Parameter({self.name!r}, {self.meaning!r}, unit={self.unit!r}, typical={self.typical!r})"


def _check_name(name: str) -> None:
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise InputError(f"{name[:45]!r} is not a usable parameter name: a letter, then letters, digits or '_'")
    if name in symbols.RESERVED:
        meaning = symbols.QUANTITIES[name].meaning
        raise InputError(
            f"{name!r} is taken: it is the {meaning} everywhere in this package; rename the parameter"
        )
    if name in FUNCTIONS:
        raise InputError(f"{name!r} is the name of a function; rename the parameter")


class FrictionLaw:
    """A velocity-dependent friction coefficient mu(v), v = abs(x' - V) >= 0.

    Parameters
    ----------
    formula : str or sympy.Expr
        The coefficient as a function of `v`; every other name is a parameter. Text is parsed by a
        whitelist and never evaluated.
    static : str or sympy.Expr, optional
        Static coefficient, where it lies above mu(0+). No slope average sees it.
    units : mapping of str to str, optional
        SI units of parameters, e.g. ``{"alpha": "s/m"}``.
    source : str, optional
        Who gave the law first.
    name : str, optional
        A short name.
    parameters : iterable of Parameter, optional
        Full descriptions, instead of `units`.

    Raises
    ------
    InputError
        If the formula cannot be read, or a parameter's name clashes with V, N, m, k, c, v, x or t.

    Examples
    --------
    >>> law = FrictionLaw("mu_m + (mu_s - mu_m)*exp(-alpha*v)")
    >>> law.bind(mu_s=0.5, mu_m=0.2, alpha=3.0).mu(0.0)
    0.5
    """

    def __init__(
        self,
        formula: str | Any,
        *,
        static: str | Any | None = None,
        units: Mapping[str, str] | None = None,
        source: str | None = None,
        name: str | None = None,
        parameters: Iterable[Parameter] = (),
    ) -> None:
        described = {parameter.name: parameter for parameter in parameters}
        for key, unit in (units or {}).items():
            described[key] = Parameter(key, unit=unit)
        table = dict(described)
        self.expr = _read(formula, table)
        self.static = None if static is None else _read(static, table)
        self.name = name
        self.source = source
        self.values: dict[str, Any] = {}
        if self.static is not None and self.static.has(symbols.v):
            raise InputError("the static coefficient is one number; it cannot depend on v")
        used = {symbol.name for symbol in self._all_symbols()}
        for unused in described.keys() - used:
            raise InputError(f"the parameter {unused!r} does not occur in the formula {printing.text(self.expr)}")
        self.parameters: dict[str, Parameter] = {key: table[key] for key in table if key in used}

    def _all_symbols(self) -> set[Any]:
        static = self.static.free_symbols if self.static is not None else set()
        return set((self.expr.free_symbols | static) - {symbols.v})

    # -- expressions -----------------------------------------------------------------------------

    @property
    def slope_expr(self) -> Any:
        """The derivative of mu with respect to the slip speed."""
        return sp.diff(self.expr, symbols.v)

    @property
    def static_expr(self) -> Any:
        """The coefficient that limits sticking: `static`, or mu(0+) where none was given."""
        return self.static if self.static is not None else sp.limit(self.expr, symbols.v, 0, "+")

    # -- values ----------------------------------------------------------------------------------

    def bind(self, **values: Number) -> "FrictionLaw":
        """Return the law with values for some or all of its parameters.

        Raises
        ------
        InputError
            For an unknown name, a value that is no finite number, or a negative value of a parameter
            that was declared positive.
        """
        read = exact_values(values)
        for key, value in read.items():
            if key not in self.parameters:
                known = ", ".join(self.parameters) or "none"
                raise InputError(
                    f"{self._label()} has no parameter {key!r}{suggestion(key, self.parameters)}; it has: {known}"
                )
            if self.parameters[key].positive and value < 0:
                raise InputError(
                    f"{key} = {float(value):g} is negative, but the law takes {key} as positive; "
                    f"declare it with Parameter({key!r}, positive=False) if any sign is meant"
                )
        bound = FrictionLaw.__new__(FrictionLaw)
        bound.expr, bound.static, bound.name, bound.source = self.expr, self.static, self.name, self.source
        bound.parameters = self.parameters
        bound.values = {**self.values, **read}
        return bound

    def typical(self, **values: Number) -> "FrictionLaw":
        """Return the law with its typical values wherever neither `bind` nor `values` gives one."""
        given = {key: p.typical for key, p in self.parameters.items() if p.typical is not None}
        return self.bind(**{**given, **self.values, **values})

    @property
    def missing(self) -> list[str]:
        """Names of the parameters that have no value yet."""
        return [key for key in self.parameters if key not in self.values]

    def substitute(self, expr: Any) -> Any:
        """Put the bound values into an expression of the law's parameters.

        Raises
        ------
        InputError
            If a parameter has no value.
        """
        if self.missing:
            names = ", ".join(self.missing)
            example = ", ".join(f"{key}=..." for key in self.missing)
            raise InputError(f"{self._label()} has no value for {names}; bind them first: law.bind({example})")
        return expr.xreplace({self.parameters[key].symbol: value for key, value in self.values.items()})

    def mu(self, v: ArrayLike) -> Any:
        """Return the friction coefficient mu(v) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, or a speed is negative or not finite.
        """
        return self._evaluate(self._mu, v)

    def slope(self, v: ArrayLike) -> Any:
        """Return the slope dmu/dv (s/m) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, or a speed is negative or not finite.
        """
        return self._evaluate(self._slope, v)

    @cached_property
    def _mu(self) -> Any:
        return function_of([symbols.v], self.substitute(self.expr), "numpy")

    @cached_property
    def _slope(self) -> Any:
        return function_of([symbols.v], self.substitute(self.slope_expr), "numpy")

    @staticmethod
    def _evaluate(function: Any, v: ArrayLike) -> Any:
        speed = np.asarray(v, dtype=np.float64)
        wrong = ~((speed >= 0) & np.isfinite(speed))
        if wrong.any():
            first = speed[wrong].flat[0]
            raise InputError(f"slip speed v = {first} is not a finite number >= 0; v is |x' - V|")
        result = np.broadcast_to(np.asarray(function(speed), dtype=np.float64), speed.shape)
        return float(result) if result.ndim == 0 else result.copy()

    def _label(self) -> str:
        return f"the law {self.name!r}" if self.name else "the law"

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={float(value):g}" for key, value in self.values.items())
        return (
            f"FrictionLaw({self.name or 'unnamed'}: {printing.text(self.expr)}{'; ' + values if values else ''})"
        )

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle \\mu(v) = {printing.latex(self.expr)}$"


def _read(formula: str | Any, table: dict[str, Parameter]) -> Any:
    """Read a formula; parameters it uses that `table` does not have are added there."""

    def symbol(name: str) -> Any:
        if name == "v":
            return symbols.v
        if name not in table:
            table[name] = Parameter(name)
        return table[name].symbol

    if isinstance(formula, str):
        expr = parse_expression(formula, symbol)
    elif isinstance(formula, sp.Expr):
        expr = _rename(formula, symbol)
    elif isinstance(formula, int | float):
        expr = exact(formula, "the coefficient")
    else:
        raise InputError(f"a law is text or a SymPy expression, got {type(formula).__name__}")
    if expr.has(sp.zoo, sp.oo, sp.nan, sp.I):
        raise InputError(f"the formula is not finite and real: it reduces to {expr}")
    return expr


def _rename(expr: Any, symbol: Any) -> Any:
    """Rebuild a SymPy expression on this package's symbols; refuse what a formula may not contain."""
    allowed = (sp.Add, sp.Mul, sp.Pow, sp.Number, sp.NumberSymbol, sp.Symbol, *FUNCTIONS_TYPES)
    for node in sp.preorder_traversal(expr):
        if not isinstance(node, allowed):
            raise InputError(f"{type(node).__name__} is not allowed in a law: {str(node)[:60]}")
    replacements = {old: symbol(old.name) for old in expr.free_symbols}
    replacements.update({number: sp.Rational(number) for number in expr.atoms(sp.Float)})
    return expr.xreplace(replacements)


FUNCTIONS_TYPES = tuple(f for f in FUNCTIONS.values() if isinstance(f, type))
