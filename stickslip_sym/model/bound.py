"""`BoundLaw`: a friction law whose parameters have values, as numbers and functions of the slip speed."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Rational
from stickslip_sym.core.balls import number_at
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lambdify import Backend
from stickslip_sym.core.numbers import SAME, read_array, real
from stickslip_sym.model import at_rest
from stickslip_sym.model.expression.pieces import branch_from, kinks_at
from stickslip_sym.model.expression.slope import slope_of
from stickslip_sym.model.samples import SampledCurve
from stickslip_sym.model.table import FrictionTable, Smooth
from stickslip_sym.model.taylor_model import RestPolynomial, coefficient_near_rest


@dataclass(frozen=True)
class BoundLaw:
    """A friction law as numbers: each is computed when it is first asked for, and kept.

    Attributes
    ----------
    expr : sympy.Expr
        The coefficient mu(v) in the slip speed and the parameters.
    static_expr : sympy.Expr or None
        The static coefficient, where it is not mu(0+).
    values : tuple of (sympy.Symbol, sympy.Rational)
        The values of the parameters, exact.
    curve : SampledCurve or None
        The curve through measured points; None for a law that is a formula.
    label : str
        The law in a message.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> bound = laws.exponential.typical().bound
    >>> bound.onset, bound.kinks, bound.obstacle(1.0)
    (0.5, (), None)
    """

    expr: Expr
    static_expr: Expr | None
    values: tuple[tuple[Expr, Rational], ...]
    curve: SampledCurve | None = field(repr=False)
    label: str

    def shared(self) -> "BoundLaw":
        """Return the law that is equal to this one and was made first: what was computed of it is kept there."""
        return _same_law(self)

    @property
    def kinetic(self) -> "BoundLaw":
        """The law without its static coefficient, which neither mu(v) nor an average of its slope knows."""
        if self.static_expr is None:
            return self
        return replace(self, static_expr=None).shared()

    def __getstate__(self) -> dict[str, object]:
        # What is compiled cannot be pickled, and is made again when it is needed.
        return {attribute.name: getattr(self, attribute.name) for attribute in fields(self)}

    # -- numbers -------------------------------------------------------------------------------------

    @cached_property
    def point(self) -> dict[Expr, Expr]:
        """The values of the parameters, exact, by symbol.

        They do not belong into expressions: SymPy expands powers of long fractions.
        """
        return dict(self.values)

    def number(self, expr: Expr) -> float:
        """Return the value of an expression of the parameters."""
        return float(number_at(expr, self.point))

    @cached_property
    def onset(self) -> float:
        """The coefficient mu(0+), where slip begins; refused where mu has no finite limit."""
        onset = at_rest.limit_at_rest(self.expr, self.point)
        if not math.isfinite(onset):
            raise InputError(
                f"mu(0+) is {onset}, not a finite number, for {self.label}, mu = {str(self.expr)[:60]}: no spring "
                "could ever pull the mass off the belt; cut the law off at a small speed, as in "
                "log(1 + v/v_c) for log(v)"
            )
        return onset

    @cached_property
    def static(self) -> float:
        """The coefficient that limits sticking, at least mu(0+); a static coefficient below that is refused."""
        onset = self.onset
        if self.static_expr is None:
            return onset
        static = real("the static coefficient", self.number(self.static_expr))
        if static < onset - SAME * abs(onset):
            raise InputError(
                f"the static coefficient {static:g} is below mu(0+) = {onset:g}: a contact that gives way would "
                "stop the mass at once; give a static coefficient of at least mu(0+), or none"
            )
        if static > onset + SAME * abs(onset):
            return static
        return onset

    @property
    def end(self) -> Rational | None:
        """The slip speed in m/s up to which the law was measured, exact; None where there is no bound."""
        return None if self.curve is None else self.curve.end

    @property
    def reach(self) -> float:
        """The same as a float, infinite where there is no bound."""
        if self.end is None:
            return math.inf
        return float(self.end)

    # -- where mu is smooth --------------------------------------------------------------------------

    @cached_property
    def exact_kinks(self) -> tuple[Expr, ...]:
        """The slip speeds v > 0 at which mu or its slope may jump, exact and ascending."""
        return tuple(kinks_at(self.expr, self.point, self.label))

    def require_kinks(self) -> None:
        """Refuse values for which a kink has no place."""
        kinks_at(self.expr, self.point, self.label)

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """The same in m/s, as floats."""
        return tuple(map(float, self.exact_kinks))

    @cached_property
    def segments(self) -> tuple[tuple[Expr, Expr], ...]:
        """Where each smooth segment of mu begins, exact and ascending from 0, and its formula."""
        starts = sp.Integer(0), *self.exact_kinks
        return tuple((start, branch_from(self.expr, self.point, start)) for start in starts)

    def obstacle(self, highest: float) -> str | None:
        """Say why motions up to a slip speed in m/s are not smooth, or return None."""
        if self.static_expr is not None and self.static > self.onset:
            return f"its static coefficient {self.static:g} lies above mu(0+) = {self.onset:g}"
        passed = self.kinks and self.kinks[0] < highest
        if passed:
            return f"it has a kink at v = {self.kinks[0]:g}, which the orbit passes"
        return None

    @cached_property
    def is_straight(self) -> bool:
        """Whether mu(v) is a straight line: every average of its slope is the same."""
        return not slope_of(self.expr).has(symbols.v) and not self.kinks

    # -- functions of the slip speed -----------------------------------------------------------------

    def function(self, backend: Backend, *, derivative: bool = False) -> Callable[[Any], Any]:
        """Return mu(v), or its slope, as a bare function of the numbers of one library; nothing is checked."""
        if self.curve is not None:
            return self.curve.function(backend, derivative=derivative)
        return at_rest.function_at(slope_of(self.expr) if derivative else self.expr, self.point, backend)

    @cached_property
    def _mu(self) -> Callable[[FloatArray], FloatArray]:
        return self.function("numpy")

    @cached_property
    def _slope(self) -> Callable[[FloatArray], FloatArray]:
        return self.function("numpy", derivative=True)

    def mu(self, v: ArrayLike) -> Any:
        """Return the friction coefficient mu(v) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a speed is negative or not finite, or mu has no real value there.
        """
        return self._checked(v, derivative=False)

    def slope(self, v: ArrayLike) -> Any:
        """Return the slope dmu/dv (s/m) at slip speeds v >= 0 (m/s), float or array; refuses as `mu` does."""
        return self._checked(v, derivative=True)

    def _checked(self, v: ArrayLike, *, derivative: bool) -> Any:
        speed = np.asarray(read_array("v", v, finite=False), np.float64)
        wrong = ~((speed >= 0) & np.isfinite(speed))
        if wrong.any():
            first = speed[wrong].flat[0]
            raise InputError(f"slip speed v = {first} is not a finite number >= 0; v is |x' - V|")
        if self.curve is not None and speed.size:
            self.curve.require_speed(speed.max(), self.label)
        result = self.at_speeds(speed, derivative=derivative)
        if (missing := np.isnan(result)).any():
            what = "slope" if derivative else "value"
            first = speed[missing].flat[0]
            raise InputError(f"{self.label} has no {what} in double precision at the slip speed v = {first}")
        return float(result) if result.ndim == 0 else result

    def at_speeds(self, speeds: FloatArray, *, derivative: bool = False) -> FloatArray:
        """Return mu, or its slope, at an array of slip speeds; NaN where it has no real value."""
        try:
            with np.errstate(all="ignore"):  # every piece of a law is computed, and one is taken
                value = at_rest.reals((self._slope if derivative else self._mu)(speeds))
        except ArithmeticError:
            value = np.asarray(np.nan)
        result = np.broadcast_to(value, speeds.shape).astype(np.float64)
        if self.near_rest is not None:  # where terms cancel
            reach, series = self.near_rest
            low = speeds <= reach
            result[low] = series.slope(speeds[low]) if derivative else series.onset + series.rise(speeds[low])
        at_zero = np.isnan(result) & (speeds == 0)
        if at_zero.any():  # where a formula such as v^p/v is 0/0
            result[at_zero] = at_rest.limit_at_rest(slope_of(self.expr) if derivative else self.expr, self.point)
        return result

    @cached_property
    def near_rest(self) -> tuple[float, RestPolynomial] | None:
        """The slip speed up to which mu is taken from its series, and that; None where its formula has a value."""
        if self.curve is not None:
            return None
        with np.errstate(all="ignore"):
            try:
                if np.isfinite(at_rest.reals(self._mu(np.zeros(1)))).all():
                    return None
            except ArithmeticError:
                pass
        return coefficient_near_rest(self.segments[0][1], self.point)

    @cached_property
    def rises(self) -> list[tuple[float, at_rest.Rising]]:
        """Where each smooth piece of mu begins, ascending from 0, and mu(v) - mu(0+) on it.

        Each function is of an array, and continues smoothly beyond the ends of its piece, where another piece
        holds. Where v is small it has the digits that are lost when two coefficients are subtracted.
        """
        if self.curve:
            return self.curve.rises
        return at_rest.rises_of(self.segments, self.point)

    @cached_property
    def table(self) -> FrictionTable:
        """The law as polynomials between slip speeds; refused where mu(0+) or mu beside it is not finite."""
        if self.static_expr is not None:
            static = self.static
            return replace(self.kinetic.table, static=static)
        return FrictionTable.of(self._smooth, self.point, self.onset, self.reach)

    @lru_cache  # noqa: B019  # equal laws share them
    def table_up_to(self, end: float) -> FrictionTable:
        """Return the table of a derivative of a law by a parameter, which may end at a slip speed in m/s."""
        return FrictionTable.of(self._smooth, self.point, self.onset, self.reach, end)

    @property
    def _smooth(self) -> list[Smooth]:
        """The segments as a table takes them; pieces of a curve are polynomials already."""
        formulas: list[Expr | None] = [None] * len(self.rises)
        if self.curve is None:
            formulas = [formula for _, formula in self.segments]
        return [Smooth(*rise, formula) for rise, formula in zip(self.rises, formulas, strict=True)]


@lru_cache
def _same_law(law: BoundLaw) -> BoundLaw:
    return law
