"""`FrictionLaw`: one expression mu(v) of the slip speed, its parameters and its source."""

import copy
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Self

from stickslip_sym.core.algebra import sp
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import Number, fractions_of, suggestion
from stickslip_sym.core.uncertain import UFloat, separated
from stickslip_sym.model.coefficient import Coefficient, limit_at_rest
from stickslip_sym.model.evaluated import Evaluated
from stickslip_sym.model.expression.parameters import Parameter, described_by, parameter_table
from stickslip_sym.model.formula import Given, Written, read_formula, read_static
from stickslip_sym.output import markup, printing

if TYPE_CHECKING:
    from stickslip_sym.model.measured.measurements import Measurements
    from stickslip_sym.model.samples import SampledCurve

__all__ = ["FrictionLaw", "Parameter", "limit_at_rest"]


class FrictionLaw(Evaluated):
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

    Examples
    --------
    >>> FrictionLaw("mu_m + (mu_s - mu_m)*exp(-alpha*v)").bind(mu_s=0.5, mu_m=0.2, alpha=3.0).mu(0.0)
    0.5
    """

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
        described = described_by(parameters, units)
        table = dict(described)
        expr = read_formula(formula, table)
        self.name, self.source, self.validity = name, source, validity
        self.static = None if static is None else read_static(static, table)
        self._values = {}
        self._uncertain: dict[str, UFloat] = {}
        own = [parameter.symbol for parameter in table.values() if parameter.symbol in expr.free_symbols]
        self._formula = Given(expr, Coefficient(expr, own))
        self._parameters = self._used(table)
        for unused in described.keys() - self._parameters.keys():
            raise InputError(f"the parameter {unused!r} does not occur in the formula {self.text}")

    @classmethod
    def written(cls, formula: Written, *, name: str, source: str, validity: str) -> Self:
        """Return the law of a text whose parameters are all described, without reading it yet."""
        law = cls.__new__(cls)
        law.name, law.source, law.validity, law.static = name, source, validity, None
        law._formula, law._values, law._uncertain = formula, {}, {}
        law._parameters = {parameter.name: parameter for parameter in formula.parameters}
        return law

    def with_static(
        self,
        static: str | float | Expr | None,
        *,
        units: Mapping[str, str] | None = None,
        parameters: Iterable[Parameter] = (),
    ) -> Self:
        """Return the law with another static coefficient, or with None without one; bound values stay.

        Parameters
        ----------
        static : str, float, sympy.Expr or None
            A number, or a formula of the law's parameters and of more that it brings.
        units, parameters : optional
            Descriptions of what it brings, as for a new law.

        Raises
        ------
        InputError
            If it cannot be read, or depends on v.

        Examples
        --------
        >>> from stickslip_sym import laws
        >>> law = laws.exponential.with_static("0.6").typical()
        >>> float(law.substitute(law.static_expr))
        0.6
        """
        described = described_by(parameters, units)
        for known in described.keys() & self.parameters.keys():
            raise InputError(f"the parameter {known!r} has its description already, by the law")
        table = {**self.parameters, **described}
        law = copy.copy(self)
        law.static = None if static is None else read_static(static, table)
        law._parameters = law._used(table)
        for unused in described.keys() - law._parameters.keys():
            raise InputError(f"the parameter {unused!r} does not occur in the static coefficient or the law")
        law._values = {key: value for key, value in self._values.items() if key in law._parameters}
        law._uncertain = {key: value for key, value in self.uncertain.items() if key in law._parameters}
        return law

    def _used(self, table: Mapping[str, Parameter]) -> dict[str, Parameter]:
        free = self.expr.free_symbols | (self.static.free_symbols if self.static is not None else set())
        return {key: table[key] for key in table if key in {symbol.name for symbol in free}}

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

        Warns
        -----
        InputWarning
            If a coefficient is held below the first measured speed.

        References
        ----------
        F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic interpolants,
        SIAM J. Sci. Stat. Comput. 5 (1984), as `scipy.interpolate.PchipInterpolator` has it.
        """
        from stickslip_sym.model.samples import SampledCurve

        return cls.from_curve(SampledCurve.through(v, mu, extrapolate=extrapolate), name=name, source=source)

    @classmethod
    def from_csv(
        cls,
        path: "str | Path | Measurements",
        *,
        extrapolate: bool = False,
        source: str | None = None,
        name: str | None = None,
    ) -> Self:
        """Return the law through the points in a file of measurements, or through what was read of it.

        The file is read as by `read_measurements`; points of one speed are averaged. The law has the file's name
        unless it is given one. Decimal numbers are taken exactly as they are written.

        Raises
        ------
        InputError
            If the file is not understood, or as in `from_samples`.
        """
        from stickslip_sym.model.measured.measurements import Measurements, read_measurements

        measured = path if isinstance(path, Measurements) else read_measurements(path)
        name = name or measured.name or "samples"
        return cls.from_samples(*measured.points(), extrapolate=extrapolate, name=name, source=source)

    @classmethod
    def from_curve(
        cls,
        curve: "SampledCurve",
        *,
        name: str | None = None,
        source: str | None = None,
        validity: str | None = None,
    ) -> Self:
        """Return the law that a piecewise cubic is."""
        law = cls(curve.expr, name=name, source=source, validity=validity)
        law._formula = Given(law.expr, Coefficient(law.expr, (), curve))
        return law

    @property
    def text(self) -> str:
        """The formula as plain text; of measured points, what goes through them."""
        return printing.text(self.expr) if self.curve is None else str(self.curve)

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The law's parameters by name; read-only."""
        return MappingProxyType(self._parameters)

    @property
    def values(self) -> Mapping[str, Rational]:
        """The bound values by name, exact; read-only."""
        exact = {key: sp.Rational(*value.as_integer_ratio()) for key, value in self._values.items()}
        return MappingProxyType(exact)

    @property
    def uncertain(self) -> Mapping[str, UFloat]:
        """The bound values that carry a standard error, with it, by name; read-only."""
        return MappingProxyType(self._uncertain)

    def bind(self, **values: Number | UFloat) -> Self:
        """Return the law with values for some or all of its parameters.

        A value may carry a standard error: text such as "0.50+/-0.02" or "0.50(2)", or a number of the library
        `uncertainties`, whose correlations are kept.

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
        numbers, errors = separated(values)
        read = fractions_of(numbers)
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
        bound._values = {**self._values, **read}
        bound._uncertain = {key: self.uncertain[key] for key in self.uncertain.keys() - read.keys()} | errors
        if not bound.missing:
            bound.kinks()  # refuses values for which a kink has no place
        return bound

    def typical(self, **values: Number | UFloat) -> Self:
        """Return the law with its typical values wherever neither `bind` nor `values` gives one."""
        given = {key: self.parameters[key].typical for key in self.missing}
        return self.bind(**{key: value for key, value in given.items() if value is not None} | values)

    def _content(self) -> tuple[object, ...]:
        described = tuple((p.symbol, p.meaning, p.unit, p.typical) for p in self.parameters.values())
        errors = frozenset((key, value.std_dev) for key, value in self.uncertain.items())
        about = self.name, self.source, self.validity, self.curve, errors
        return self.expr, self.static, *about, described, frozenset(self._values.items())

    def __eq__(self, other: object) -> bool:
        """Whether two laws are the same in formula, values and description."""
        return isinstance(other, FrictionLaw) and self._content() == other._content()

    def __hash__(self) -> int:
        return hash(self._content())

    def __repr__(self) -> str:
        errors = {key: f"+/-{value.std_dev:.2g}" for key, value in self.uncertain.items()}
        values = ", ".join(f"{key}={float(value):g}{errors.get(key, '')}" for key, value in self._values.items())
        return f"FrictionLaw({self.name or 'unnamed'}: {self.text}{'; ' + values if values else ''})"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self._latex()}$" if self.curve is None else f"$\\mu(v)$: {self.text}"

    def _latex(self) -> str:
        return f"\\mu(v) = {printing.latex(self.expr)}"

    def _repr_html_(self) -> str:
        head = self.text if self.curve is not None else markup.formula(self._latex())
        static = self.static if self.static is None else printing.text(self.static)
        known = {"static coefficient": static, "validity": self.validity, "source": self.source}
        notes = [f"{kind}: {text}" for kind, text in known.items() if text]
        table = [parameter_table(self.parameters, self.values)] if self.parameters else []
        return markup.block(self.name or "friction law", head, *table, *notes)
