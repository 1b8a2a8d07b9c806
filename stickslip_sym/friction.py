"""`FrictionLaw`: one expression mu(v) of the slip speed, its parameters and its source."""

import copy
import math
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym import html_text, printing, symbols
from stickslip_sym.codegen import Backend
from stickslip_sym.compiled import Compiled
from stickslip_sym.errors import InputError
from stickslip_sym.formula import read_formula
from stickslip_sym.parameters import Parameter, parameter_table
from stickslip_sym.pieces import branch_from, places
from stickslip_sym.samples import SampledCurve, read_csv
from stickslip_sym.values import Number, exact_values, suggestion

__all__ = ["FrictionLaw", "Parameter", "limit_at_rest"]


@lru_cache(maxsize=256)
def limit_at_rest(expr: Any) -> float:
    """Return the limit of an expression in v as v falls to 0; NaN where none is found."""
    # SymPy says in these ways that it finds no limit, or that it is not real.
    try:
        return float(sp.limit(expr, symbols.v, 0, "+"))
    except (ArithmeticError, NotImplementedError, TypeError, ValueError):
        return math.nan


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
    validity : str, optional
        Where the law holds, in a sentence.

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
        validity: str | None = None,
    ) -> None:
        described = {parameter.name: parameter for parameter in parameters}
        for key, unit in (units or {}).items():
            described[key] = Parameter(key, unit=unit)
        table = dict(described)
        self.expr = read_formula(formula, table)
        self.static = None if static is None else read_formula(static, table)
        self.name = name
        self.source = source
        self.validity = validity
        self._values: dict[str, Any] = {}
        self.curve: SampledCurve | None = None
        if self.static is not None and self.static.has(symbols.v):
            raise InputError("the static coefficient is one number; it cannot depend on v")
        used = {symbol.name for symbol in self._all_symbols()}
        for unused in described.keys() - used:
            raise InputError(f"the parameter {unused!r} does not occur in the formula {printing.text(self.expr)}")
        self._parameters = {key: table[key] for key in table if key in used}
        self._compiled = Compiled([parameter.symbol for parameter in self._parameters.values()])

    @classmethod
    def from_samples(
        cls,
        v: Iterable[Number],
        mu: Iterable[Number],
        *,
        extrapolate: bool = False,
        name: str = "samples",
        source: str | None = None,
    ) -> Self:
        """Return the law through measured points: a piecewise cubic that rises and falls only where they do.

        Parameters
        ----------
        v : sequence of 4 to 60 numbers
            Slip speeds in m/s, ascending, the first one 0 unless `extrapolate`.
        mu : sequence of as many numbers
            Coefficients of friction. The first one is mu(0+); a higher static coefficient is no slip speed's.
        extrapolate : bool
            Hold the first coefficient down to v = 0, and the last one for all higher speeds. Otherwise
            speeds beyond the last are errors: a criterion at the belt speed V needs mu up to 2 V.
        name, source : str, optional

        Raises
        ------
        InputError
            For too few or too many points, or speeds that are negative, repeated or not in order.

        References
        ----------
        F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic interpolants,
        SIAM J. Sci. Stat. Comput. 5 (1984), as `scipy.interpolate.PchipInterpolator` has it.
        """
        return cls.from_curve(SampledCurve.through(v, mu, extrapolate=extrapolate), name=name, source=source)

    @classmethod
    def from_csv(cls, path: str | Path, *, extrapolate: bool = False, source: str | None = None) -> Self:
        """Return the law through the points in a CSV file: a header, then a slip speed and a coefficient a line.

        The law has the file's name. Decimal numbers are taken exactly as they are written.

        Raises
        ------
        InputError
            If the file cannot be read, or as in `from_samples`.
        """
        if not isinstance(path, str | Path) or not str(path):
            raise InputError(f"the name of a CSV file is text, got {path!r}")
        path = Path(path)
        return cls.from_samples(*read_csv(path), extrapolate=extrapolate, name=path.stem, source=source)

    @classmethod
    def from_curve(
        cls,
        curve: SampledCurve,
        *,
        name: str | None = None,
        source: str | None = None,
        validity: str | None = None,
    ) -> Self:
        """Return the law that a piecewise cubic is."""
        law = cls(curve.expr, name=name, source=source, validity=validity)
        law.curve = curve
        return law

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

    @property
    def text(self) -> str:
        """The formula as plain text; of measured points, what goes through them."""
        return printing.text(self.expr) if self.curve is None else str(self.curve)

    @property
    def v_max(self) -> Any | None:
        """The slip speed in m/s up to which the law is known, exact; None if there is no bound."""
        return None if self.curve is None else self.curve.end

    def require_speed(self, v: Any) -> None:
        """Refuse a slip speed beyond the last measured one.

        Raises
        ------
        InputError
            With both speeds, and what to do.
        """
        if self.v_max is not None and v > self.v_max:
            raise InputError(
                f"{self._label()} is measured up to v = {float(self.v_max):g} m/s, and its value at "
                f"{float(v):g} m/s is needed; measure further, take a lower speed, or hold the last "
                "coefficient: extrapolate=True, or --extrapolate"
            )

    # -- values ----------------------------------------------------------------------------------

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The law's parameters by name; read-only."""
        return MappingProxyType(self._parameters)

    @property
    def values(self) -> Mapping[str, Any]:
        """The bound values by name, exact; read-only."""
        return MappingProxyType(self._values)

    def bind(self, **values: Number) -> Self:
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
        bound = copy.copy(self)
        bound._values = {**self.values, **read}
        if not bound.missing:
            bound.kinks()  # refuses values for which a kink has no place
        return bound

    def typical(self, **values: Number) -> Self:
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
        self._require_values()
        return expr.xreplace({self.parameters[key].symbol: value for key, value in self.values.items()})

    def _require_values(self) -> None:
        if self.missing:
            names = ", ".join(self.missing)
            example = ", ".join(f"{key}=..." for key in self.missing)
            raise InputError(f"{self._label()} has no value for {names}; bind them first: law.bind({example})")

    def mu(self, v: ArrayLike) -> Any:
        """Return the friction coefficient mu(v) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, a speed is negative or not finite, or mu has no real value there.
        """
        return self._evaluate(v, derivative=False)

    def slope(self, v: ArrayLike) -> Any:
        """Return the slope dmu/dv (s/m) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, a speed is negative or not finite, or mu has no real slope there.
        """
        return self._evaluate(v, derivative=True)

    def function(self, backend: Backend, *, derivative: bool = False) -> Callable[[Any], Any]:
        """Return mu(v), or its slope, as a bare function of one library's numbers; nothing is checked.

        Parameters
        ----------
        backend : {"numpy", "math", "mpmath"}
        derivative : bool
            Return the slope.
        """
        self._require_values()
        if self.curve is not None:
            return self.curve.function(backend, derivative=derivative)
        expr = self.slope_expr if derivative else self.expr
        return self._compiled.at(expr, [self.values[name] for name in self.parameters], backend)

    def kinks(self) -> list[Any]:
        """Return the slip speeds v > 0 at which mu or its slope may jump, exact and ascending."""
        found = {self.substitute(place) for place in places(self.expr)}
        for place in found:
            if not place.is_real:
                raise InputError(f"{self._label()} has a kink at v = {str(place)[:40]}, which is not real")
        return sorted(place for place in found if place > 0)

    def branches(self) -> list[tuple[float, Callable[[float], float]]]:
        """Return where each smooth piece of mu begins, ascending from 0, and its bare function of a float.

        A piece goes on smoothly beyond its ends, where it is another one that holds.
        """
        if self.curve is not None:
            return self.curve.branches
        starts = [sp.Integer(0), *self.kinks()]
        if len(starts) == 1:
            return [(0.0, self.function("math"))]
        return [(float(start), self._branch(start)) for start in starts]

    def _branch(self, start: Any) -> Callable[[float], float]:
        expr = branch_from(
            self.expr, {self.parameters[key].symbol: value for key, value in self.values.items()}, start
        )
        function = self._compiled.at(expr, [self.values[name] for name in self.parameters], "math")
        return lambda v: float(function(v))

    def _evaluate(self, v: ArrayLike, *, derivative: bool) -> Any:
        speed = np.asarray(v, dtype=np.float64)
        wrong = ~((speed >= 0) & np.isfinite(speed))
        if wrong.any():
            first = speed[wrong].flat[0]
            raise InputError(f"slip speed v = {first} is not a finite number >= 0; v is |x' - V|")
        if speed.size:
            self.require_speed(speed.max())
        try:
            with np.errstate(all="ignore"):  # every branch of a law in pieces is computed, and one is taken
                value = np.asarray(self.function("numpy", derivative=derivative)(speed))
        except ArithmeticError:
            value = np.asarray(np.nan)
        result = np.broadcast_to(np.where(np.isreal(value), value.real, np.nan), speed.shape).astype(np.float64)
        if (np.isnan(result) & (speed == 0)).any():
            result[np.isnan(result) & (speed == 0)] = self._limit_at_rest(derivative)
        if (missing := np.isnan(result)).any():
            what, first = "slope" if derivative else "value", speed[missing].flat[0]
            raise InputError(f"{self._label()} has no {what} in double precision at the slip speed v = {first}")
        return float(result) if result.ndim == 0 else result

    def _limit_at_rest(self, derivative: bool) -> float:
        """Return the limit at v = 0+, where a formula such as v^p/v is 0/0; nan if there is none."""
        expr = self.substitute(self.slope_expr if derivative else self.expr)
        return limit_at_rest(expr)

    def _content(self) -> tuple[Any, ...]:
        described = tuple((p.symbol, p.meaning, p.unit, p.typical) for p in self.parameters.values())
        about = self.name, self.source, self.validity, self.curve
        return self.expr, self.static, *about, described, frozenset(self.values.items())

    def __eq__(self, other: object) -> bool:
        """Whether two laws are the same in formula, values and description."""
        return isinstance(other, FrictionLaw) and self._content() == other._content()

    def __hash__(self) -> int:
        return hash(self._content())

    def _label(self) -> str:
        return f"the law {self.name!r}" if self.name else "the law"

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={float(value):g}" for key, value in self.values.items())
        return f"FrictionLaw({self.name or 'unnamed'}: {self.text}{'; ' + values if values else ''})"

    def _repr_latex_(self) -> str:
        if self.curve is not None:
            return f"$\\mu(v)$: {self.text}"
        return f"$\\displaystyle {self._latex()}$"

    def _latex(self) -> str:
        return f"\\mu(v) = {printing.latex(self.expr)}"

    def _repr_html_(self) -> str:
        head = self.text if self.curve is not None else html_text.formula(self._latex())
        static = None if self.static is None else printing.text(self.static)
        known = {"static coefficient": static, "validity": self.validity, "source": self.source}
        notes = [f"{kind}: {text}" for kind, text in known.items() if text]
        tables = [parameter_table(self.parameters, self.values)] if self.parameters else []
        return html_text.block(self.name or "friction law", head, *tables, *notes)
