"""The catalogue of friction laws. To add a law, add one entry; every property test picks it up.

"First source not confirmed" marks an attribution that the authors of this package could not check in the
cited work itself. Typical values are for trying a law out: they make it fall somewhere in 0.1 to 1 m/s.
"""

from collections import UserDict
from collections.abc import Callable
from functools import partial
from typing import Any, Self

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import lookup, suggestion
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.parsing import NAME
from stickslip_sym.model.expression.reading import require_evaluation
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output import markup, printing

__all__ = ["Catalogue", "as_law", "laws"]


class Catalogue(UserDict[str, FrictionLaw]):
    """Friction laws by name, also as attributes; each is read when it is first asked for."""

    data: dict[str, Any]

    def __getitem__(self, name: str) -> FrictionLaw:
        entry: FrictionLaw | Callable[[], FrictionLaw] = self.data[name]
        if not isinstance(entry, FrictionLaw):
            entry = self.data[name] = entry()
        return entry

    def __getattr__(self, name: str) -> FrictionLaw:
        if name.startswith("_") or name == "data" or name not in self:
            known = [] if name == "data" else list(self)
            raise AttributeError(f"there is no law {name!r}{suggestion(name, known)}")
        return self[name]

    def __repr__(self) -> str:
        return f"Catalogue({', '.join(self)})"

    def __dir__(self) -> list[str]:
        return sorted([*super().__dir__(), *self])

    @property
    def catalogue(self) -> Self:
        """The catalogue itself, as a mapping."""
        return self

    def _repr_html_(self) -> str:
        rows = [
            [name, markup.formula(f"\\mu(v) = {printing.latex(law.expr)}"), law.source or ""]
            for name, law in self.items()
        ]
        return markup.block(markup.table(["law", "coefficient of friction", "source"], rows))

    def find(self, name: str) -> FrictionLaw:
        """Return a law by its name; for another name the refusal suggests the closest one."""
        return lookup("law", name, self)


def as_law(law: FrictionLaw | str | float | Expr) -> FrictionLaw:
    """Return the friction law that is meant: a law itself, the name of one of the catalogue, or a formula.

    Text that is one name is that of a law of the catalogue, unless it begins with mu: a constant coefficient.
    """
    require_evaluation()
    if isinstance(law, FrictionLaw):
        return law
    if isinstance(law, str) and NAME.fullmatch(law.strip()) and not law.strip().startswith("mu"):
        return laws.find(law.strip())
    if isinstance(law, str | int | float | sp.Basic):
        return FrictionLaw(law)
    raise InputError(
        "a friction law is needed: a FrictionLaw, the name of a law of the catalogue, or a formula such as "
        f"'mu_s - a*v'; got {type(law).__name__}"
    )


_PARAMETERS = (
    Parameter("mu_s", "friction coefficient at v = 0+", "1", typical="0.5"),
    Parameter("mu_m", "lowest friction coefficient", "1", typical="0.2"),
    Parameter("mu_k", "Coulomb friction coefficient, without Stribeck and viscous parts", "1", typical="0.2"),
    Parameter("mu_p", "breakaway friction coefficient, reached at a small slip speed", "1", typical="0.5"),
    Parameter("mu_v", "viscous rise of the coefficient per slip speed", "s/m", typical="0.05"),
    Parameter("alpha", "decay rate of the coefficient", "s/m", typical="3"),
    Parameter("beta", "quadratic rise of the coefficient", "s^2/m^2", typical="0.05"),
    Parameter("v_m", "slip speed of the lowest coefficient", "m/s", typical="1"),
    Parameter("v_s", "Stribeck speed, on the scale of which the coefficient falls", "m/s", typical="0.5"),
    Parameter("v_b", "breakaway speed", "m/s", typical="0.1"),
    Parameter("v_c", "cut-off speed of the logarithm", "m/s", typical="0.001"),
    Parameter("v_0", "smoothing speed, on the scale of which friction builds up", "m/s", typical="0.01"),
    Parameter("v_1", "speed scale of the fast drop", "m/s", typical="0.05"),
    Parameter("v_2", "speed scale of the slow drop", "m/s", typical="0.5"),
    Parameter("d_1", "part of the drop that is lost fast", "1", typical="0.15"),
    Parameter("d_2", "part of the drop that is lost slowly", "1", typical="0.15"),
    Parameter("b_a", "fall of the coefficient per natural logarithm of the speed", "1", typical="0.03"),
    Parameter("delta", "Stribeck exponent", "1", typical="1.5"),
    Parameter("a_1", "coefficient of v", "s/m", typical="-0.6", positive=False),
    Parameter("a_2", "coefficient of v^2", "s^2/m^2", typical="0.1", positive=False),
    Parameter("a_3", "coefficient of v^3", "s^3/m^3", typical="0.3", positive=False),
    Parameter("a_5", "coefficient of v^5", "s^5/m^5", typical="0.05", positive=False),
)
_OF_LINEAR = (Parameter("a_1", "fall of the coefficient per slip speed", "s/m", typical="0.15"),)
_OF_KRAGELSKII = (
    Parameter("a_0", "coefficient at v = 0+ above that at high speed", "1", typical="0.3"),
    Parameter("a_1", "linear part of the decaying term", "s/m", typical="0.2"),
    Parameter("a_2", "coefficient at high speed", "1", typical="0.2"),
)
_UNCONFIRMED = " (first source not confirmed)"

_LAWS = (
    # Laws with a jump at v = 0: friction from the first slip on.
    ("coulomb", "mu_k", "mu_k",
     "dry contacts over a moderate range of speeds; never falls, so only a static coefficient excites",
     "Coulomb 1785"),
    ("coulomb_viscous", "mu_k + mu_v*v", "mu_k mu_v",
     "greased guides beyond the Stribeck dip; never falls",
     "Coulomb with a viscous term, of no one author"),
    ("linear", "mu_s - a_1*v", "mu_s a_1",
     "near one belt speed; negative beyond v = mu_s/a_1",
     "linearisation, textbook", _OF_LINEAR),
    ("exponential", "mu_m + (mu_s - mu_m)*exp(-alpha*v)", "mu_s mu_m alpha",
     "dry contacts; falls at all speeds if mu_s > mu_m",
     "Won & Chung 2016, eq. (3); earlier Tustin 1947" + _UNCONFIRMED),
    ("exponential_viscous", "mu_k + (mu_s - mu_k)*exp(-alpha*v) + mu_v*v", "mu_s mu_k alpha mu_v",
     "lubricated contacts through the Stribeck dip; falls at first if alpha (mu_s - mu_k) > mu_v",
     "Tustin 1947" + _UNCONFIRMED),
    ("gaussian", "mu_m + (mu_s - mu_m)*exp(-(v/v_s)^2)", "mu_s mu_m v_s",
     "lubricated metals; flat at v = 0+, steepest at v_s/sqrt(2), constant beyond 2 v_s",
     "Armstrong-Helouvry 1991" + _UNCONFIRMED),
    ("gaussian_viscous", "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^2) + mu_v*v", "mu_s mu_k v_s mu_v",
     "steady sliding of the LuGre model; rises with mu_v at v = 0+, dips, and rises again",
     "Canudas de Wit, Olsson, Astrom & Lischinsky 1995" + _UNCONFIRMED),
    ("stribeck", "mu_m + (mu_s - mu_m)*exp(-(v/v_s)^delta)", "mu_s mu_m v_s delta",
     "any Stribeck curve without viscous rise; the slope at v = 0+ is infinite for delta < 1",
     "Bo & Pavelescu 1982" + _UNCONFIRMED),
    ("stribeck_viscous", "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^delta) + mu_v*v", "mu_s mu_k v_s delta mu_v",
     "dry to fully lubricated steady friction; the slope at v = 0+ is infinite for delta < 1",
     "Armstrong-Helouvry, Dupont & Canudas de Wit 1994" + _UNCONFIRMED),
    ("lorentzian", "mu_m + (mu_s - mu_m)/(1 + (v/v_s)^2)", "mu_s mu_m v_s",
     "mixed lubrication; flat at v = 0+, steepest at v_s/sqrt(3), algebraic tail",
     "Hess & Soom 1990, without its viscous term" + _UNCONFIRMED),
    ("lorentzian_viscous", "mu_k + (mu_s - mu_k)/(1 + (v/v_s)^2) + mu_v*v", "mu_s mu_k v_s mu_v",
     "lubricated line contacts from boundary to full film; dips if mu_v < 0.65 (mu_s - mu_k)/v_s",
     "Hess & Soom 1990" + _UNCONFIRMED),
    ("hyperbolic", "mu_m + (mu_s - mu_m)/(1 + v/v_s)", "mu_s mu_m v_s",
     "dry contacts with a slow fall, such as rosin, rubber or brake blocks",
     "Bochet 1861; for stick-slip oscillators Popp & Stelter 1990" + _UNCONFIRMED),
    ("popp_stelter", "mu_k + (mu_s - mu_k)/(1 + v/v_s) + beta*v^2", "mu_s mu_k v_s beta",
     "dry friction oscillators; falls, then rises; not to be extrapolated",
     "Popp & Stelter 1990; Hinrichs, Oestreich & Popp 1998" + _UNCONFIRMED),
    ("polynomial", "mu_s - 3*(mu_s - mu_m)/(2*v_m)*v + (mu_s - mu_m)/(2*v_m^3)*v^3", "mu_s mu_m v_m",
     "up to a little beyond the minimum at v_m; passes mu_s again at sqrt(3) v_m",
     "Thomsen & Fidlin 2003; Won & Chung 2016, eq. (4)"),
    ("quintic", "mu_s + a_1*v + a_3*v^3 + a_5*v^5", "mu_s a_1 a_3 a_5",
     "a fit, inside the fitted speeds only",
     "odd polynomial, as in oscillators of van der Pol's and Rayleigh's kind"),
    ("cubic", "mu_s + a_1*v + a_2*v^2 + a_3*v^3", "mu_s a_1 a_2 a_3",
     "a fit, inside the fitted speeds only",
     "polynomial fit, as for robot joints in Visioli & Legnani 2002" + _UNCONFIRMED),
    ("logarithmic", "mu_s - b_a*log(1 + v/v_c)", "mu_s b_a v_c",
     "steady rate-and-state weakening (b > a), cut off below v_c; negative at extreme speeds",
     "Dieterich 1979, Ruina 1983; the cut-off is this package's"),
    ("arcsinh", "mu_s - b_a*asinh(v/(2*v_c))", "mu_s b_a v_c",
     "as the logarithmic law, analytic at v = 0",
     "after the regularisation of Rice & Ben-Zion 1996; applied to b - a it is this package's"),
    ("arctangent", "mu_s - (mu_s - mu_m)*2/pi*atan(v/v_s)", "mu_s mu_m v_s",
     "a saturating fall with an algebraic tail, empirical",
     "of no one author"),
    ("tanh", "mu_s - (mu_s - mu_m)*tanh(v/v_s)", "mu_s mu_m v_s",
     "a saturating fall without curvature at v = 0+, empirical",
     "of no one author"),
    ("sech", "mu_m + (mu_s - mu_m)*sech(v/v_s)", "mu_s mu_m v_s",
     "a Stribeck drop, flat at v = 0+, with an exponential tail",
     "Feeny & Moon 1994, without its smoothing factor" + _UNCONFIRMED),
    ("two_exponentials", "mu_m + d_1*exp(-v/v_1) + d_2*exp(-v/v_2)", "mu_m d_1 v_1 d_2 v_2",
     "rosin on a bow, and any curve with a fast and a slow drop",
     "Smith & Woodhouse 2000" + _UNCONFIRMED),
    ("kragelskii", "(a_0 + a_1*v)*exp(-alpha*v) + a_2", "a_0 a_1 alpha a_2",
     "dry solids; with a maximum at v > 0 if a_1 > alpha a_0",
     "Kragelskii 1965" + _UNCONFIRMED, _OF_KRAGELSKII),
    ("rational", "(0.5 + 0.3*v/v_s + 0.25*(v/v_s)^2)/(1 + v/v_s + (v/v_s)^2)", "v_s",
     "an example of a fitted ratio of polynomials with numbers for coefficients",
     "this package"),
    # Smoothed laws, mu(0) = 0: no jump, hence no stick, only slow creep.
    ("andersson", "(mu_k + (mu_p - mu_k)*exp(-(v/v_s)^delta))*tanh(v/v_0) + mu_v*v",
     "mu_p mu_k v_s delta v_0 mu_v",
     "simulation without a stick state; needs v_0 far below v_s",
     "Andersson, Soderberg & Bjorklund 2007"),
    ("brown_mcphee", "mu_k*tanh(4*v/v_b) + (mu_p - mu_k)*(v/v_b)/((v/v_b)^2/4 + 3/4)^2 + mu_v*v",
     "mu_p mu_k v_b mu_v",
     "multibody simulation; the maximum, about mu_p, lies near v_b",
     "Brown & McPhee 2016"),
    ("simscape",
     "sqrt(2*exp(1))*(mu_p - mu_k)*exp(-(v/(sqrt(2)*v_b))^2)*v/(sqrt(2)*v_b) + mu_k*tanh(10*v/v_b) + mu_v*v",
     "mu_p mu_k v_b mu_v",
     "simulation without a stick state; the maximum, about mu_p, lies at v_b",
     "MathWorks, Simscape block Translational Friction"),
    ("bengisu_akay", "(1 - exp(-v/v_0))*(mu_k + (mu_p - mu_k)*exp(-alpha*v))", "mu_p mu_k v_0 alpha",
     "simulation without a stick state; needs alpha v_0 far below 1",
     "Bengisu & Akay 1994" + _UNCONFIRMED),
)  # fmt: skip
"""Name, formula, parameters in order, validity and source, and parameters that mean something else in this law."""


def _read(
    name: str, formula: str, names: str, validity: str, source: str, own: tuple[Parameter, ...] = ()
) -> FrictionLaw:
    described = {parameter.name: parameter for parameter in (*_PARAMETERS, *own)}
    parameters = [described[parameter] for parameter in names.split()]
    return FrictionLaw(formula, parameters=parameters, name=name, validity=validity, source=source)


laws = Catalogue()
"""Every law of the catalogue."""
laws.data |= {entry[0]: partial(_read, *entry) for entry in _LAWS}
