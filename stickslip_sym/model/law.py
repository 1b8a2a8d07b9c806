"""`FrictionLaw`: one expression mu(v) of the slip speed, its parameters and its source."""

import copy
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self, SupportsFloat, overload

import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.foreign import printable
from stickslip_sym.core.lambdify import Backend
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.numbers import Number, exact, require_type
from stickslip_sym.core.remedies import AnySign, Argument, ParameterValues
from stickslip_sym.core.uncertain import UFloat, separated, spread
from stickslip_sym.core.units import si_number
from stickslip_sym.model import at_rest
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.expression.dimensions import check_units
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.pieces import rate
from stickslip_sym.model.expression.reading import as_text, read_formula
from stickslip_sym.model.expression.slope import slope_of
from stickslip_sym.model.leading_terms import symbolic_limit_at_rest
from stickslip_sym.model.measured.measurements import Measurements, read_measurements
from stickslip_sym.model.samples import SampledCurve
from stickslip_sym.model.terms import Term, terms_of
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.output import printing
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.shown import Shown, views_of

if TYPE_CHECKING:
    from stickslip_sym.output.shown import Axes, Figure


class FrictionLaw(Shown, DataResult):
    """A velocity-dependent friction coefficient mu(v), v = abs(x' - V) >= 0.

    Parameters
    ----------
    formula : str or sympy.Expr
        The coefficient as a function of `v`; every other name is a parameter. Text is parsed by a
        whitelist and never evaluated. A name that is probably v misspelt, or meant as a constant, is refused
        or warned of, unless `units` or `parameters` have it.
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
        Where it holds, in a sentence.

    Raises
    ------
    InputError
        If the formula cannot be read, or a parameter's name clashes with V, N, m, k, c, v, x or t, or is that of
        a constant or of a speed.

    Warns
    -----
    InputWarning
        If the formula has no v, or vr beside v.

    Attributes
    ----------
    expr : sympy.Expr
        The coefficient as an expression in the slip speed and the parameters.
    static : sympy.Expr or None
    formula, static_formula : str or None
        The texts from which these were read; None for what was computed of another law.
    curve : SampledCurve or None
        The curve through measured points; None for a law that is a formula.
    name, source, validity : str or None

    Notes
    -----
    At a jump mu is the value of the piece above it, whether a condition reads `v < place` or `v <= place`:
    friction takes any value between both there, and no motion, average or threshold depends on which is named.

    Examples
    --------
    >>> FrictionLaw("mu_m + (mu_s - mu_m)*exp(-alpha*v)").bind(mu_s=0.5, mu_m=0.2, alpha=3.0).mu(0.0)
    0.5
    """

    reported = ("name", "text", "static", "values", "uncertain", "parameters", "validity", "source")

    def __init__(
        self,
        formula: str | float | Expr,
        *,
        static: str | float | Expr | None = None,
        units: Mapping[str, str] | None = None,
        source: str | None = None,
        name: str | None = None,
        parameters: Iterable[Parameter] = (),
        validity: str | None = None,
    ) -> None:
        for key, value in {"source": source, "name": name, "validity": validity}.items():
            require_type(key, value, str | None, "text")
        described = _described(parameters, units)
        table = dict(described)
        self.formula: str | None = as_text(formula)
        self.expr = read_formula(self.formula, table)
        self._read_static(static, table)
        self.curve: SampledCurve | None = None
        about = (None if value is None else printable(value) for value in (name, source, validity))
        self.name, self.source, self.validity = about
        self._values: dict[str, Rational] = {}
        self._uncertain: dict[str, UFloat] = {}
        self._take(table, described)

    @classmethod
    def from_curve(
        cls,
        curve: SampledCurve,
        *,
        name: str | None = None,
        source: str | None = None,
        validity: str | None = None,
    ) -> Self:
        """Return the law that a piecewise cubic is, with its name, its source, and where it holds."""
        law = cls(0, name=name, source=source, validity=validity)
        law.expr = curve.expr
        law.curve = curve
        return law

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

        Warns
        -----
        InputWarning
            If a coefficient is held below the first measured speed.

        References
        ----------
        F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic interpolants,
        SIAM J. Sci. Stat. Comput. 5 (1984), as `scipy.interpolate.PchipInterpolator` has it.
        """
        return cls.from_curve(SampledCurve.through(v, mu, extrapolate=extrapolate), name=name, source=source)

    @classmethod
    def from_csv(
        cls,
        path: str | Path | Measurements,
        *,
        extrapolate: bool = False,
        source: str | None = None,
        name: str | None = None,
    ) -> Self:
        """Return the law through the points in a file of measurements, or through what was read of it.

        The file is read as by `read_measurements`; points of one speed are averaged. The law has the file's name
        unless it is given one. Decimal numbers are taken exactly as they are written. What `from_samples` refuses
        is refused here.
        """
        measured = path if isinstance(path, Measurements) else read_measurements(path)
        name = name or measured.name or "samples"
        return cls.from_samples(*measured.points(), extrapolate=extrapolate, name=name, source=source)

    def _read_static(self, static: str | float | Expr | None, table: dict[str, Parameter]) -> None:
        self.static_formula = None if static is None else as_text(static)
        formula = self.static_formula
        self.static: Expr | None = None if formula is None else read_formula(formula, table, constant=True)

    def _take(self, table: Mapping[str, Parameter], described: Iterable[str]) -> None:
        """Keep the parameters that occur, with their values; refuse others that are described, and wrong units."""
        coefficients = [self.expr] if self.static is None else [self.expr, self.static]
        used = {symbol.name for coefficient in coefficients for symbol in coefficient.free_symbols}
        for unused in set(described) - used:
            raise InputError(f"the parameter {unused!r} does not occur in the formula {self.text}")
        self._parameters = {key: parameter for key, parameter in table.items() if key in used}
        self._values = {key: value for key, value in self._values.items() if key in used}
        self._uncertain = {key: value for key, value in self._uncertain.items() if key in used}
        for coefficient in coefficients:
            check_units(coefficient, {parameter.symbol: parameter.unit for parameter in self._parameters.values()})

    def with_static(
        self,
        static: str | float | Expr | None,
        *,
        units: Mapping[str, str] | None = None,
        parameters: Iterable[Parameter] = (),
    ) -> Self:
        """Return the law with another static coefficient, or with None without one; bound values stay.

        It is a number, or a formula of the law's parameters, but not of v, and of more that it brings; `units` and
        `parameters` describe these, as for a new law.

        Examples
        --------
        >>> from stickslip_sym import laws
        >>> laws.exponential.with_static("0.6").typical().static_value
        0.6
        """
        described = _described(parameters, units)
        for known in described.keys() & self.parameters.keys():
            raise InputError(f"the parameter {known!r} has its description already, by the law")
        table = {**self.parameters, **described}
        law = copy.copy(self)
        law._read_static(static, table)
        law._take(table, described)
        return law

    # -- what it is ----------------------------------------------------------------------------------

    @property
    def text(self) -> str:
        """The formula as plain text; of measured points, what goes through them."""
        if self.curve is None:
            return printing.text(self.expr)
        return str(self.curve)

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The law's parameters by name; read-only."""
        return MappingProxyType(self._parameters)

    @property
    def values(self) -> Mapping[str, Rational]:
        """The bound values by name, exact; read-only."""
        return MappingProxyType(self._values)

    @property
    def uncertain(self) -> Mapping[str, UFloat]:
        """The bound values that carry a standard error, with it, by name; read-only."""
        return MappingProxyType(self._uncertain)

    @property
    def missing(self) -> list[str]:
        """Names of the parameters that have no value yet."""
        return [key for key in self._parameters if key not in self._values]

    def _label(self) -> str:
        return f"the law {self.name!r}" if self.name else "the law"

    @property
    def terms(self) -> tuple[Term, ...]:
        """The terms amplitude * profile(v / scale; shapes) whose sum the coefficient is."""
        if self.curve is None:
            return terms_of(self.expr)
        # Numbers alone: no scale would leave fewer shapes, and each of many would be tried.
        return (Term(sp.Integer(1), sp.Integer(1), self.expr, {}),)

    @property
    def slope_expr(self) -> Expr:
        """The derivative of mu with respect to the slip speed."""
        return slope_of(self.expr)

    @property
    def static_expr(self) -> Expr:
        """The coefficient that limits sticking: `static`, or mu(0+) where none was given."""
        if self.static is not None:
            return self.static
        limit = symbolic_limit_at_rest(self.expr)
        if isinstance(limit, Unknown):
            raise InputError(
                f"no limit mu(0+) was found for {self._label()}, {self.text[:60]}; give the static coefficient: ",
                Argument("static"),
            )
        return limit

    def partial(self, name: str) -> Self:
        """Return the law dmu/dp of a parameter p, or v mu' - mu for "V"; each piece by itself.

        The slope of the second is v mu'': how slopes change as the belt's speed grows, relative to that.
        """
        if name != "V" and name not in self._parameters:
            raise InputError(f"{self._label()} has no parameter {name!r}; it has: {', '.join(self._parameters)}")
        law = copy.copy(self)
        if name == "V":
            law.expr = symbols.v * self.slope_expr - self.expr
        else:
            law.expr = rate(self.expr, self._parameters[name].symbol)
        law.curve = law.static = law.formula = law.static_formula = None
        return law

    # -- values --------------------------------------------------------------------------------------

    def bind(self, **values: Number | UFloat) -> Self:
        """Return the law with values for some or all of its parameters.

        Text may have a unit, as "30 mm/s". A value may carry a standard error: text such as "0.50+/-0.02" or
        "0.50(2)", or a number of the library `uncertainties`, whose correlations are kept.

        Raises
        ------
        InputError
            For an unknown name, a value that is no finite number, or a negative value of a parameter
            that was declared positive.

        Examples
        --------
        >>> law = FrictionLaw("mu_m + (mu_s - mu_m)*exp(-alpha*v)").bind(mu_s="0.50+/-0.02", alpha="3.0(1)")
        >>> float(law.values["mu_s"]), law.uncertain["mu_s"].std_dev
        (0.5, 0.02)
        """
        units = {key: (self.parameters[key].unit if key in self.parameters else None) or "" for key in values}
        numbers, errors = separated({key: si_number(value, key, units[key]) for key, value in values.items()})
        read = {name: exact(value, name) for name, value in numbers.items()}
        for key, value in read.items():
            if key not in self.parameters:
                known = ", ".join(self.parameters) or "none"
                raise InputError(
                    f"{self._label()} has no parameter {key!r}{suggestion(key, self.parameters)}; it has: {known}"
                )
            if self.parameters[key].positive and value < 0:
                raise InputError(
                    f"{key} = {float(value):g} is negative, but the law takes {key} as positive; "
                    "if any sign is meant, ",
                    AnySign(key),
                )
        bound = copy.copy(self)
        bound._values = {**self._values, **read}
        bound._uncertain = {key: error for key, error in self._uncertain.items() if key not in read} | errors
        if not bound.expr.free_symbols & {bound.parameters[key].symbol for key in bound.missing}:
            bound.kinetic.require_kinks()
        return bound

    def with_errors(self, uncertain: Mapping[str, UFloat]) -> Self:
        """Return the law with these standard errors; to `bind` them would round its exact values to doubles."""
        law = copy.copy(self)
        law._uncertain = dict(uncertain)
        return law

    def typical(self, **values: Number | UFloat) -> Self:
        """Return the law with its typical values wherever neither `bind` nor `values` gives one."""
        usual = {key: self.parameters[key].typical for key in self.missing}
        return self.bind(**{key: value for key, value in usual.items() if value is not None} | values)

    @cached_property
    def bound(self) -> BoundLaw:
        """The law as numbers; parameters without a value are refused, by name."""
        if self.static is None:
            return self.kinetic
        return self._with_values(self.static)

    @cached_property
    def kinetic(self) -> BoundLaw:
        """The same of mu(v) alone: what only the static coefficient has needs no value."""
        return self._with_values(None)

    def _with_values(self, static: Expr | None) -> BoundLaw:
        self.require_values(*(() if static is None else (static,)))
        values = [(of.symbol, self._values[key]) for key, of in self._parameters.items() if key in self._values]
        return BoundLaw(self.expr, static, tuple(values), self.curve, self._label()).shared()

    def require_values(self, *exprs: Expr) -> None:
        """Refuse parameters of mu(v), and of other expressions, that have no value, by name."""
        if not self.missing:
            return
        used = {symbol.name for expr in (self.expr, *exprs) for symbol in expr.free_symbols}
        if missing := [key for key in self.missing if key in used]:
            raise InputError(
                f"{self._label()} has no value for {', '.join(missing)}; give it first: ",
                ParameterValues.of(*missing),
            )

    @property
    def point(self) -> dict[Expr, Expr]:
        """The values of the parameters, exact, by symbol; those of the static coefficient alone may have none."""
        return dict(self.kinetic.point)

    def number(self, expr: Expr) -> float:
        """Return the value of an expression of the law's parameters."""
        self.require_values(expr)
        return self.kinetic.number(expr)

    @property
    def onset(self) -> float:
        """The coefficient mu(0+), where slip begins; refused where mu has no finite limit."""
        return self.kinetic.onset

    @property
    def static_value(self) -> float:
        """The coefficient that limits sticking, at least mu(0+); a static coefficient below that is refused."""
        return self.bound.static

    @property
    def v_max(self) -> Rational | None:
        """The slip speed in m/s up to which the law is known, exact; None if there is no bound."""
        return None if self.curve is None else self.curve.end

    def require_speed(self, v: SupportsFloat) -> None:
        """Refuse a slip speed beyond the last measured one, with both speeds, and what to do."""
        if self.curve is not None:
            self.curve.require_speed(v, self._label())

    def kinks(self) -> list[Expr]:
        """Return the slip speeds v > 0 at which mu or its slope may jump, exact and ascending."""
        return list(self.kinetic.exact_kinks)

    @overload
    def mu(self, v: float) -> float: ...
    @overload
    def mu(self, v: ArrayLike) -> FloatArray: ...
    def mu(self, v: ArrayLike) -> Any:
        """Return the friction coefficient mu(v) at slip speeds v >= 0 (m/s), float or array.

        Raises
        ------
        InputError
            If a parameter has no value, a speed is negative or not finite, or mu has no real value there.
        """
        return self.kinetic.mu(v)

    @overload
    def slope(self, v: float) -> float: ...
    @overload
    def slope(self, v: ArrayLike) -> FloatArray: ...
    def slope(self, v: ArrayLike) -> Any:
        """Return the slope dmu/dv (s/m) at slip speeds v >= 0 (m/s), float or array; refuses as `mu` does."""
        return self.kinetic.slope(v)

    def function(self, backend: Backend, *, derivative: bool = False) -> Callable[[Any], Any]:
        """Return mu(v), or its slope, as a bare function of the numbers of one library; nothing is checked."""
        return self.kinetic.function(backend, derivative=derivative)

    def at_speeds(self, speeds: FloatArray, *, derivative: bool = False) -> FloatArray:
        """Return mu, or its slope, at an array of slip speeds; NaN where it has no real value."""
        return self.kinetic.at_speeds(speeds, derivative=derivative)

    def rises(self) -> list[tuple[float, at_rest.Rising]]:
        """Return where each smooth piece of mu begins, and mu(v) - mu(0+) on it, as `BoundLaw.rises`."""
        return list(self.kinetic.rises)

    def plot(self, path: str | Path | None = None, *, v_max: float = 1.0, ax: "Axes | None" = None) -> "Figure":
        """Draw mu over the slip speed, with the 95 % band of values that carry standard errors.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to: SVG, PNG or PDF, by its ending.
        v_max : float
            The highest slip speed, in m/s; thresholds depend on those up to 2 V.
        ax : matplotlib.axes.Axes, optional
            Axes of a figure of your own.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If a parameter has no value (`typical` gives each a usual one), `v_max` is not positive, matplotlib is
            not installed, or the file cannot be written.
        """
        return views_of(self).plot(self, path, ax, v_max=v_max)

    def _repr_latex_(self) -> str:
        return views_of(self).notebook_latex(self)

    def __repr__(self) -> str:
        return views_of(self).one_line(self)

    # -- comparing ----------------------------------------------------------------------

    def _content(self) -> tuple[object, ...]:
        about = self.name, self.source, self.validity, self.curve, spread(self.uncertain)
        return (
            self.expr,
            self.static,
            *about,
            frozenset(self._parameters.values()),
            frozenset(self._values.items()),
        )

    def __getstate__(self) -> dict[str, object]:
        # A copy is made to have other values, and numbers are computed again where a law is sent.
        return {name: value for name, value in self.__dict__.items() if name not in ("bound", "kinetic")}

    def __eq__(self, other: object) -> bool:
        """Whether two laws are the same in formula, values and description."""
        return isinstance(other, FrictionLaw) and self._content() == other._content()

    def __hash__(self) -> int:
        return hash(self._content())


def _described(parameters: Iterable[Parameter], units: Mapping[str, str] | None) -> dict[str, Parameter]:
    """Return the parameters that a user describes, by name."""
    require_type("units", units, Mapping | None, "a mapping such as {'alpha': 's/m'}")
    require_type("parameters", parameters, Iterable, "an iterable of Parameter")
    for parameter in (parameters := list(parameters)):
        require_type("a parameter", parameter, Parameter, "a Parameter")
    described = {parameter.name: parameter for parameter in parameters}
    return described | {key: Parameter(key, unit=unit) for key, unit in (units or {}).items()}
