"""The catalogue of friction laws. To add a law, add one entry; every property test picks it up.

"First source not confirmed" marks an attribution that the authors of this package could not check in the
cited work itself. Typical values are for trying a law out: they make it fall somewhere in 0.1 to 1 m/s.
"""

from collections.abc import Callable, Iterator, MutableMapping
from typing import Self

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import lookup, suggestion
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.parsing import NAME
from stickslip_sym.model.law import FrictionLaw

__all__ = ["Catalogue", "as_law", "laws"]

_UNCONFIRMED = " (first source not confirmed)"

_MU_S = Parameter("mu_s", "friction coefficient at v = 0+", "1", typical="0.5")
_MU_M = Parameter("mu_m", "lowest friction coefficient", "1", typical="0.2")
_MU_K = Parameter("mu_k", "Coulomb friction coefficient, without Stribeck and viscous parts", "1", typical="0.2")
_MU_P = Parameter("mu_p", "breakaway friction coefficient, reached at a small slip speed", "1", typical="0.5")
_MU_V = Parameter("mu_v", "viscous rise of the coefficient per slip speed", "s/m", typical="0.05")
_ALPHA = Parameter("alpha", "decay rate of the coefficient", "s/m", typical="3")
_V_M = Parameter("v_m", "slip speed of the lowest coefficient", "m/s", typical="1")
_V_S = Parameter("v_s", "Stribeck speed, on the scale of which the coefficient falls", "m/s", typical="0.5")
_V_B = Parameter("v_b", "breakaway speed", "m/s", typical="0.1")
_V_C = Parameter("v_c", "cut-off speed of the logarithm", "m/s", typical="0.001")
_V_0 = Parameter("v_0", "smoothing speed, on the scale of which friction builds up", "m/s", typical="0.01")
_B_A = Parameter("b_a", "fall of the coefficient per natural logarithm of the speed", "1", typical="0.03")
_DELTA = Parameter("delta", "Stribeck exponent", "1", typical="1.5")
_A_1 = Parameter("a_1", "coefficient of v", "s/m", typical="-0.6", positive=False)
_A_3 = Parameter("a_3", "coefficient of v^3", "s^3/m^3", typical="0.3", positive=False)


class Catalogue(MutableMapping[str, FrictionLaw]):
    """Friction laws by name, also as attributes; each is read when it is first asked for."""

    def __init__(self) -> None:
        self._entries: dict[str, FrictionLaw | Callable[[], FrictionLaw]] = {}

    def __getitem__(self, name: str) -> FrictionLaw:
        entry = self._entries[name]
        if not isinstance(entry, FrictionLaw):
            entry = self._entries[name] = entry()
        return entry

    def __setitem__(self, name: str, law: FrictionLaw | Callable[[], FrictionLaw]) -> None:
        self._entries[name] = law

    def __delitem__(self, name: str) -> None:
        del self._entries[name]

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __getattr__(self, name: str) -> FrictionLaw:
        if name.startswith("_") or name not in self:
            raise AttributeError(f"there is no law {name!r}{suggestion(name, self._names)}")
        return self[name]

    def __dir__(self) -> list[str]:
        return sorted([*super().__dir__(), *self])

    @property
    def _names(self) -> dict[str, None]:
        return dict.fromkeys(self._entries)

    @property
    def catalogue(self) -> Self:
        """The catalogue itself, as a mapping."""
        return self

    def find(self, name: str) -> FrictionLaw:
        """Return a law by its name.

        Raises
        ------
        InputError
            If there is none; the message suggests the closest name.
        """
        self.check_name(name)
        return self[name]

    def check_name(self, name: str) -> None:
        """Refuse the name of no law, as `find` does; the law itself is not read.

        Raises
        ------
        InputError
        """
        lookup("law", name, self._names)


laws = Catalogue()
"""Every law of the catalogue."""


def as_law(law: FrictionLaw | str | float | Expr) -> FrictionLaw:
    """Return the friction law that is meant: a law itself, the name of one of the catalogue, or a formula.

    Parameters
    ----------
    law : FrictionLaw, str, float or sympy.Expr
        Text that is one name is that of a law of the catalogue, unless it begins with mu: a constant coefficient.

    Raises
    ------
    InputError
        For anything else, and for a formula that cannot be read.

    Examples
    --------
    >>> as_law("exponential").text == as_law("mu_m + (mu_s - mu_m)*exp(-alpha*v)").text
    True
    """
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


def _law(name: str, formula: str, *parameters: Parameter, validity: str, source: str) -> None:
    laws[name] = lambda: FrictionLaw(formula, parameters=parameters, name=name, validity=validity, source=source)


# -- laws with a jump at v = 0: friction from the first slip on ------------------------------------

_law(
    "coulomb", "mu_k", _MU_K,
    validity="dry contacts over a moderate range of speeds; never falls, so only a static coefficient excites",
    source="Coulomb 1785",
)  # fmt: skip
_law(
    "coulomb_viscous", "mu_k + mu_v*v", _MU_K, _MU_V,
    validity="greased guides beyond the Stribeck dip; never falls",
    source="Coulomb with a viscous term, of no one author",
)  # fmt: skip
_law(
    "linear", "mu_s - a_1*v",
    _MU_S, Parameter("a_1", "fall of the coefficient per slip speed", "s/m", typical="0.15"),
    validity="near one belt speed; negative beyond v = mu_s/a_1",
    source="linearisation, textbook",
)  # fmt: skip
_law(
    "exponential", "mu_m + (mu_s - mu_m)*exp(-alpha*v)", _MU_S, _MU_M, _ALPHA,
    validity="dry contacts; falls at all speeds if mu_s > mu_m",
    source="Won & Chung 2016, eq. (3); earlier Tustin 1947" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "exponential_viscous", "mu_k + (mu_s - mu_k)*exp(-alpha*v) + mu_v*v", _MU_S, _MU_K, _ALPHA, _MU_V,
    validity="lubricated contacts through the Stribeck dip; falls at first if alpha (mu_s - mu_k) > mu_v",
    source="Tustin 1947" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "gaussian", "mu_m + (mu_s - mu_m)*exp(-(v/v_s)^2)", _MU_S, _MU_M, _V_S,
    validity="lubricated metals; flat at v = 0+, steepest at v_s/sqrt(2), constant beyond 2 v_s",
    source="Armstrong-Helouvry 1991" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "gaussian_viscous", "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^2) + mu_v*v", _MU_S, _MU_K, _V_S, _MU_V,
    validity="steady sliding of the LuGre model; rises with mu_v at v = 0+, dips, and rises again",
    source="Canudas de Wit, Olsson, Astrom & Lischinsky 1995" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "stribeck", "mu_m + (mu_s - mu_m)*exp(-(v/v_s)^delta)", _MU_S, _MU_M, _V_S, _DELTA,
    validity="any Stribeck curve without viscous rise; the slope at v = 0+ is infinite for delta < 1",
    source="Bo & Pavelescu 1982" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "stribeck_viscous", "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^delta) + mu_v*v", _MU_S, _MU_K, _V_S, _DELTA, _MU_V,
    validity="dry to fully lubricated steady friction; the slope at v = 0+ is infinite for delta < 1",
    source="Armstrong-Helouvry, Dupont & Canudas de Wit 1994" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "lorentzian", "mu_m + (mu_s - mu_m)/(1 + (v/v_s)^2)", _MU_S, _MU_M, _V_S,
    validity="mixed lubrication; flat at v = 0+, steepest at v_s/sqrt(3), algebraic tail",
    source="Hess & Soom 1990, without its viscous term" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "lorentzian_viscous", "mu_k + (mu_s - mu_k)/(1 + (v/v_s)^2) + mu_v*v", _MU_S, _MU_K, _V_S, _MU_V,
    validity="lubricated line contacts from boundary to full film; dips if mu_v < 0.65 (mu_s - mu_k)/v_s",
    source="Hess & Soom 1990" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "hyperbolic", "mu_m + (mu_s - mu_m)/(1 + v/v_s)", _MU_S, _MU_M, _V_S,
    validity="dry contacts with a slow fall, such as rosin, rubber or brake blocks",
    source="Bochet 1861; for stick-slip oscillators Popp & Stelter 1990" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "popp_stelter", "mu_k + (mu_s - mu_k)/(1 + v/v_s) + beta*v^2",
    _MU_S, _MU_K, _V_S, Parameter("beta", "quadratic rise of the coefficient", "s^2/m^2", typical="0.05"),
    validity="dry friction oscillators; falls, then rises; not to be extrapolated",
    source="Popp & Stelter 1990; Hinrichs, Oestreich & Popp 1998" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "polynomial", "mu_s - 3*(mu_s - mu_m)/(2*v_m)*v + (mu_s - mu_m)/(2*v_m^3)*v^3", _MU_S, _MU_M, _V_M,
    validity="up to a little beyond the minimum at v_m; passes mu_s again at sqrt(3) v_m",
    source="Thomsen & Fidlin 2003; Won & Chung 2016, eq. (4)",
)  # fmt: skip
_law(
    "quintic", "mu_s + a_1*v + a_3*v^3 + a_5*v^5",
    _MU_S, _A_1, _A_3, Parameter("a_5", "coefficient of v^5", "s^5/m^5", typical="0.05", positive=False),
    validity="a fit, inside the fitted speeds only",
    source="odd polynomial, as in oscillators of van der Pol's and Rayleigh's kind",
)  # fmt: skip
_law(
    "cubic", "mu_s + a_1*v + a_2*v^2 + a_3*v^3",
    _MU_S, _A_1, Parameter("a_2", "coefficient of v^2", "s^2/m^2", typical="0.1", positive=False), _A_3,
    validity="a fit, inside the fitted speeds only",
    source="polynomial fit, as for robot joints in Visioli & Legnani 2002" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "logarithmic", "mu_s - b_a*log(1 + v/v_c)", _MU_S, _B_A, _V_C,
    validity="steady rate-and-state weakening (b > a), cut off below v_c; negative at extreme speeds",
    source="Dieterich 1979, Ruina 1983; the cut-off is this package's",
)  # fmt: skip
_law(
    "arcsinh", "mu_s - b_a*asinh(v/(2*v_c))", _MU_S, _B_A, _V_C,
    validity="as the logarithmic law, analytic at v = 0",
    source="after the regularisation of Rice & Ben-Zion 1996; applied to b - a it is this package's",
)  # fmt: skip
_law(
    "arctangent", "mu_s - (mu_s - mu_m)*2/pi*atan(v/v_s)", _MU_S, _MU_M, _V_S,
    validity="a saturating fall with an algebraic tail, empirical",
    source="of no one author",
)  # fmt: skip
_law(
    "tanh", "mu_s - (mu_s - mu_m)*tanh(v/v_s)", _MU_S, _MU_M, _V_S,
    validity="a saturating fall without curvature at v = 0+, empirical",
    source="of no one author",
)  # fmt: skip
_law(
    "sech", "mu_m + (mu_s - mu_m)*sech(v/v_s)", _MU_S, _MU_M, _V_S,
    validity="a Stribeck drop, flat at v = 0+, with an exponential tail",
    source="Feeny & Moon 1994, without its smoothing factor" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "two_exponentials", "mu_m + d_1*exp(-v/v_1) + d_2*exp(-v/v_2)",
    _MU_M,
    Parameter("d_1", "part of the drop that is lost fast", "1", typical="0.15"),
    Parameter("v_1", "speed scale of the fast drop", "m/s", typical="0.05"),
    Parameter("d_2", "part of the drop that is lost slowly", "1", typical="0.15"),
    Parameter("v_2", "speed scale of the slow drop", "m/s", typical="0.5"),
    validity="rosin on a bow, and any curve with a fast and a slow drop",
    source="Smith & Woodhouse 2000" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "kragelskii", "(a_0 + a_1*v)*exp(-alpha*v) + a_2",
    Parameter("a_0", "coefficient at v = 0+ above that at high speed", "1", typical="0.3"),
    Parameter("a_1", "linear part of the decaying term", "s/m", typical="0.2"),
    _ALPHA,
    Parameter("a_2", "coefficient at high speed", "1", typical="0.2"),
    validity="dry solids; with a maximum at v > 0 if a_1 > alpha a_0",
    source="Kragelskii 1965" + _UNCONFIRMED,
)  # fmt: skip
_law(
    "rational", "(0.5 + 0.3*v/v_s + 0.25*(v/v_s)^2)/(1 + v/v_s + (v/v_s)^2)", _V_S,
    validity="an example of a fitted ratio of polynomials with numbers for coefficients",
    source="this package",
)  # fmt: skip

# -- smoothed laws, mu(0) = 0: no jump, hence no stick, only slow creep ----------------------------

_law(
    "andersson", "(mu_k + (mu_p - mu_k)*exp(-(v/v_s)^delta))*tanh(v/v_0) + mu_v*v",
    _MU_P, _MU_K, _V_S, _DELTA, _V_0, _MU_V,
    validity="simulation without a stick state; needs v_0 far below v_s",
    source="Andersson, Soderberg & Bjorklund 2007",
)  # fmt: skip
_law(
    "brown_mcphee", "mu_k*tanh(4*v/v_b) + (mu_p - mu_k)*(v/v_b)/((v/v_b)^2/4 + 3/4)^2 + mu_v*v",
    _MU_P, _MU_K, _V_B, _MU_V,
    validity="multibody simulation; the maximum, about mu_p, lies near v_b",
    source="Brown & McPhee 2016",
)  # fmt: skip
_law(
    "simscape",
    "sqrt(2*exp(1))*(mu_p - mu_k)*exp(-(v/(sqrt(2)*v_b))^2)*v/(sqrt(2)*v_b) + mu_k*tanh(10*v/v_b) + mu_v*v",
    _MU_P, _MU_K, _V_B, _MU_V,
    validity="simulation without a stick state; the maximum, about mu_p, lies at v_b",
    source="MathWorks, Simscape block Translational Friction",
)  # fmt: skip
_law(
    "bengisu_akay", "(1 - exp(-v/v_0))*(mu_k + (mu_p - mu_k)*exp(-alpha*v))", _MU_P, _MU_K, _V_0, _ALPHA,
    validity="simulation without a stick state; needs alpha v_0 far below 1",
    source="Bengisu & Akay 1994" + _UNCONFIRMED,
)  # fmt: skip
