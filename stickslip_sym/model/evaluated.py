"""`Evaluated`: what is computed of a friction law once its parameters have values, each answer checked."""

import copy
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Self, SupportsFloat

from stickslip_sym.core import symbols
from stickslip_sym.core.algebra import sp
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lambdify import Backend
from stickslip_sym.model.coefficient import Coefficient, limit_at_rest
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.formula import Formula, Given
from stickslip_sym.output import printing

if TYPE_CHECKING:  # a formula is derived without NumPy
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from stickslip_sym.model.samples import SampledCurve

__all__ = ["Evaluated"]


class Evaluated:
    """A law's coefficient, slope and special speeds; `FrictionLaw` has these, and gives the formula and values."""

    static: Expr | None
    name: str | None
    _parameters: dict[str, Parameter]
    _values: dict[str, Fraction]
    _formula: Formula

    @property
    def expr(self) -> Expr:
        """The coefficient as an expression in the slip speed and the parameters."""
        return self._formula.expr

    @property
    def _coefficient(self) -> Coefficient:
        return self._formula.coefficient

    @property
    def curve(self) -> "SampledCurve | None":
        """The curve through measured points; None for a law that is a formula."""
        return None if self._formula.ready else self._coefficient.curve

    @property
    def slope_expr(self) -> Expr:
        """The derivative of mu with respect to the slip speed."""
        return sp.diff(self.expr, symbols.v)

    @property
    def static_expr(self) -> Expr:
        """The coefficient that limits sticking: `static`, or mu(0+) where none was given.

        Raises
        ------
        InputError
            If no limit is found.
        """
        from stickslip_sym.model.expression.pieces import at_rest

        if self.static is not None:
            return self.static
        limit = _limit(at_rest(self.expr, self._known()))
        if limit is None:
            raise InputError(
                f"no limit mu(0+) was found for {self._label()}, {printing.text(self.expr)[:60]}; "
                "give the static coefficient: static=..."
            )
        return limit

    @property
    def v_max(self) -> Rational | None:
        """The slip speed in m/s up to which the law is known, exact; None if there is no bound."""
        return None if self.curve is None else self.curve.end

    def require_speed(self, v: SupportsFloat) -> None:
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
                "coefficient: extrapolate=True"
            )

    @property
    def missing(self) -> list[str]:
        """Names of the parameters that have no value yet."""
        return [key for key in self._parameters if key not in self._values]

    def substitute(self, expr: Expr) -> Expr:
        """Put the bound values into an expression of the law's parameters.

        Raises
        ------
        InputError
            If a parameter has no value.
        """
        self._require_values()
        return expr.xreplace(self._known())

    def _known(self) -> dict[Expr, Expr]:
        return {
            self._parameters[key].symbol: sp.Rational(*value.as_integer_ratio())
            for key, value in self._values.items()
        }

    def _require_values(self) -> None:
        if self.missing:
            names = ", ".join(self.missing)
            example = ", ".join(f"{key}=..." for key in self.missing)
            raise InputError(f"{self._label()} has no value for {names}; bind them first: law.bind({example})")

    def partial(self, name: str) -> Self:
        """Return the law dmu/dp of a parameter p, or v mu' - mu for "V"; each piece by itself.

        The slope of the second is v mu'': how slopes change as the belt's speed grows, relative to that.

        Raises
        ------
        InputError
            If there is no such parameter.
        """
        if name != "V" and name not in self._parameters:
            raise InputError(f"{self._label()} has no parameter {name!r}; it has: {', '.join(self._parameters)}")
        law = copy.copy(self)
        symbol = symbols.V if name == "V" else self._parameters[name].symbol
        coefficient = _partial(self.expr, symbol)
        law._formula, law.static = Given(coefficient.expr, coefficient), None
        law._parameters = {k: p for k, p in self._parameters.items() if p.symbol in law.expr.free_symbols}
        law._values = {key: value for key, value in self._values.items() if key in law._parameters}
        return law

    def mu(self, v: "ArrayLike") -> Any:
        """Return the friction coefficient mu(v) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, a speed is negative or not finite, or mu has no real value there.
        """
        return self._evaluate(v, derivative=False)

    def slope(self, v: "ArrayLike") -> Any:
        """Return the slope dmu/dv (s/m) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, a speed is negative or not finite, or mu has no real slope there.
        """
        return self._evaluate(v, derivative=True)

    def at_speeds(self, speeds: "NDArray[np.float64]") -> "NDArray[np.float64]":
        """Return mu at an array of slip speeds; NaN where it has no real value, and nothing is refused.

        Raises
        ------
        InputError
            If a parameter has no value.
        """
        return self._at_speeds(speeds, derivative=False)

    def _at_speeds(self, speeds: "NDArray[np.float64]", *, derivative: bool) -> "NDArray[np.float64]":
        import numpy as np

        try:
            with np.errstate(all="ignore"):  # every piece of a law is computed, and one is taken
                value = np.asarray(self.function("numpy", derivative=derivative)(speeds))
        except ArithmeticError:
            value = np.asarray(np.nan)
        result = np.broadcast_to(np.where(np.isreal(value), value.real, np.nan), speeds.shape).astype(np.float64)
        at_zero = np.isnan(result) & (speeds == 0)
        if at_zero.any():  # where a formula such as v^p/v is 0/0
            result[at_zero] = limit_at_rest(self.substitute(self.slope_expr if derivative else self.expr))
        return result

    def function(self, backend: Backend, *, derivative: bool = False) -> Callable[[Any], Any]:
        """Return mu(v), or its slope, as a bare function of one library's numbers; nothing is checked.

        Parameters
        ----------
        backend : {"numpy", "math", "mpmath"}
        derivative : bool
            Return the slope.
        """
        self._require_values()
        if (ready := self._formula.ready) is not None and backend == "numpy":
            compiled = ready.slope if derivative else ready.mu
            floats = [float(self._values[name]) for name in ready.parameters]
            return lambda v: compiled(v, *floats)
        return self._coefficient.function(self._known(), backend, derivative=derivative)

    def kinks(self) -> list[Expr]:
        """Return the slip speeds v > 0 at which mu or its slope may jump, exact and ascending."""
        self._require_values()
        if self._formula.ready:
            return []
        found = self._coefficient.kinks(self._known())
        for place in found:
            if not place.is_real:
                raise InputError(f"{self._label()} has a kink at v = {str(place)[:40]}, which is not real")
        return sorted(place for place in found if place > 0)

    def rises(self, backend: Backend = "math") -> list[tuple[float, Callable[[Any], Any]]]:
        """Return where each smooth piece of mu begins, ascending from 0, and mu(v) - mu(0+) on it.

        Each function continues smoothly beyond the ends of its piece, where another piece holds. Where v is small
        it has the digits that are lost when two coefficients are subtracted.

        Parameters
        ----------
        backend : {"math", "numpy"}
            Whether they are functions of a float, or of an array, with NaN where mu has no value.
        """
        return self._coefficient.rises(self._known(), self.kinks() if self.curve is None else (), backend)

    def by_piece(self, names: Sequence[str] = ()) -> Callable[..., Any]:
        """Return mu of arrays of slip speeds and of the places of its smooth pieces, as a bare function.

        Each piece continues smoothly beyond its ends. Further arguments are values of the parameters `names`.
        """
        self._require_values()
        if (ready := self._formula.ready) is None:
            return self._coefficient.by_piece(self._known(), self.kinks() if self.curve is None else (), names)
        compiled, places = ready.mu, [list(ready.parameters).index(name) for name in names]
        floats = [float(self._values[name]) for name in ready.parameters]

        def mu(v: Any, _: Any, *given: Any) -> Any:
            arguments: list[Any] = list(floats)
            for place, column in zip(places, given, strict=True):
                arguments[place] = column
            return compiled(v, *arguments)

        return mu

    def _evaluate(self, v: "ArrayLike", *, derivative: bool) -> Any:
        import numpy as np

        speed = np.asarray(v, dtype=np.float64)
        wrong = ~((speed >= 0) & np.isfinite(speed))
        if wrong.any():
            first = speed[wrong].flat[0]
            raise InputError(f"slip speed v = {first} is not a finite number >= 0; v is |x' - V|")
        if speed.size:
            self.require_speed(speed.max())
        result = self._at_speeds(speed, derivative=derivative)
        if (missing := np.isnan(result)).any():
            what, first = "slope" if derivative else "value", speed[missing].flat[0]
            raise InputError(f"{self._label()} has no {what} in double precision at the slip speed v = {first}")
        return float(result) if result.ndim == 0 else result

    def _label(self) -> str:
        return f"the law {self.name!r}" if self.name else "the law"


@lru_cache(maxsize=512)
def _partial(expr: Expr, symbol: Expr) -> Coefficient:
    partial = symbols.v * sp.diff(expr, symbols.v) - expr if symbol == symbols.V else sp.diff(expr, symbol)
    return Coefficient(partial, sorted(partial.free_symbols - {symbols.v}, key=str))


def _limit(expr: Expr) -> Expr | None:
    """Return the limit of mu as v falls to 0, case by case where the sign of a place is not known."""
    for node in expr.atoms(sp.Piecewise):
        cases = [(_limit(expr.xreplace({node: part})), holds) for part, holds in node.args]
        return None if any(part is None for part, _ in cases) else sp.Piecewise(*cases)
    try:
        limit = sp.limit(expr, symbols.v, 0, "+")
    except (ArithmeticError, NotImplementedError, TypeError, ValueError):
        return None
    return None if limit.has(sp.Limit, sp.AccumBounds, sp.nan, sp.I) else limit
