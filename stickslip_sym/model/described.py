"""`DescribedLaw`: what a friction law says of itself, as text, LaTeX and HTML."""

from collections.abc import Mapping
from types import MappingProxyType

from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.uncertain import UFloat, with_error
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.samples import SampledCurve
from stickslip_sym.output import markup, printing
from stickslip_sym.output.notation import notation_of


class DescribedLaw:
    """A formula or a curve with its parameters, their values, and where it comes from."""

    name: str | None
    source: str | None
    validity: str | None
    expr: Expr
    static: Expr | None
    curve: SampledCurve | None
    _parameters: Mapping[str, Parameter]
    _values: Mapping[str, Rational]
    _uncertain: Mapping[str, UFloat]

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

    def __repr__(self) -> str:
        errors = {key: f"+/-{value.std_dev:.2g}" for key, value in self.uncertain.items()}
        values = ", ".join(f"{key}={float(value):g}{errors.get(key, '')}" for key, value in self._values.items())
        return f"FrictionLaw({self.name or 'unnamed'}: {self.text}{'; ' + values if values else ''})"

    def _repr_latex_(self) -> str:
        shown = f"\\mu(v) = {printing.latex(self.expr)}"
        return f"$\\displaystyle {shown}$" if self.curve is None else f"$\\mu(v)$: {self.text}"

    def _repr_html_(self) -> str:
        head = self.text if self.curve is not None else markup.formula(f"\\mu(v) = {printing.latex(self.expr)}")
        static = None if self.static is None else printing.text(self.static)
        about = {"static coefficient": static, "validity": self.validity, "source": self.source}
        notes = [f"{kind}: {text}" for kind, text in about.items() if text]
        names = notation_of(self._parameters)
        values = {key: f"{float(value):g}" for key, value in self._values.items()}
        values |= {key: with_error(error.nominal_value, error.std_dev) for key, error in self.uncertain.items()}
        rows = [
            [markup.formula(names[key]), values.get(key, ""), of.typical or "", of.unit or "", of.meaning]
            for key, of in self._parameters.items()
        ]
        table = [markup.table(["parameter", "value", "typical", "unit", "meaning"], rows)] if rows else []
        return markup.block(self.name or "friction law", head, *table, *notes)
