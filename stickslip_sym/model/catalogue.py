"""The texts of the catalogue of friction laws. To add a law, add one entry; every property test picks it up.

"First source not confirmed" marks an attribution that the authors of this package could not check in the
cited work itself. Typical values are for trying a law out: they make it fall somewhere in 0.1 to 1 m/s.
Nothing large is imported here, since the command line completes names of laws and parameters.
"""

from typing import NamedTuple


class ParameterEntry(NamedTuple):
    """A parameter of laws, with what it means, its unit, a typical value, and whether it is never negative."""

    name: str
    meaning: str
    unit: str
    typical: str
    positive: bool = True


class LawEntry(NamedTuple):
    """A law: its formula, its parameters in order, where it holds, and its source.

    The parameters are described in `PARAMETERS`, or among the law's own where they mean something else in it.
    """

    name: str
    formula: str
    parameters: str
    validity: str
    source: str
    own: tuple[ParameterEntry, ...] = ()


PARAMETERS = (
    ParameterEntry("mu_s", "friction coefficient at v = 0+", "1", typical="0.5"),
    ParameterEntry("mu_m", "lowest friction coefficient", "1", typical="0.2"),
    ParameterEntry("mu_k", "Coulomb friction coefficient, without Stribeck and viscous parts", "1", typical="0.2"),
    ParameterEntry("mu_p", "breakaway friction coefficient, reached at a small slip speed", "1", typical="0.5"),
    ParameterEntry("mu_v", "viscous rise of the coefficient per slip speed", "s/m", typical="0.05"),
    ParameterEntry("alpha", "decay rate of the coefficient", "s/m", typical="3"),
    ParameterEntry("beta", "quadratic rise of the coefficient", "s^2/m^2", typical="0.05"),
    ParameterEntry("v_m", "slip speed of the lowest coefficient", "m/s", typical="1"),
    ParameterEntry("v_s", "Stribeck speed, on the scale of which the coefficient falls", "m/s", typical="0.5"),
    ParameterEntry("v_b", "breakaway speed", "m/s", typical="0.1"),
    ParameterEntry("v_c", "cut-off speed of the logarithm", "m/s", typical="0.001"),
    ParameterEntry("v_0", "smoothing speed, on the scale of which friction builds up", "m/s", typical="0.01"),
    ParameterEntry("v_1", "speed scale of the fast drop", "m/s", typical="0.05"),
    ParameterEntry("v_2", "speed scale of the slow drop", "m/s", typical="0.5"),
    ParameterEntry("d_1", "part of the drop that is lost fast", "1", typical="0.15"),
    ParameterEntry("d_2", "part of the drop that is lost slowly", "1", typical="0.15"),
    ParameterEntry("b_a", "fall of the coefficient per natural logarithm of the speed", "1", typical="0.03"),
    ParameterEntry("delta", "Stribeck exponent", "1", typical="1.5"),
    ParameterEntry("a_1", "coefficient of v", "s/m", typical="-0.6", positive=False),
    ParameterEntry("a_2", "coefficient of v^2", "s^2/m^2", typical="0.1", positive=False),
    ParameterEntry("a_3", "coefficient of v^3", "s^3/m^3", typical="0.3", positive=False),
    ParameterEntry("a_5", "coefficient of v^5", "s^5/m^5", typical="0.05", positive=False),
)
_OF_LINEAR = (ParameterEntry("a_1", "fall of the coefficient per slip speed", "s/m", typical="0.15"),)
_OF_KRAGELSKII = (
    ParameterEntry("a_0", "coefficient at v = 0+ above that at high speed", "1", typical="0.3"),
    ParameterEntry("a_1", "linear part of the decaying term", "s/m", typical="0.2"),
    ParameterEntry("a_2", "coefficient at high speed", "1", typical="0.2"),
)
_UNCONFIRMED = " (first source not confirmed)"

ENTRIES = (
    # Laws with a jump at v = 0: friction from the first slip on.
    LawEntry("coulomb", "mu_k", "mu_k",
     "dry contacts over a moderate range of speeds; never falls, so only a static coefficient excites",
     "Coulomb 1785"),
    LawEntry("coulomb_viscous", "mu_k + mu_v*v", "mu_k mu_v",
     "greased guides beyond the Stribeck dip; never falls",
     "Coulomb with a viscous term, of no one author"),
    LawEntry("linear", "mu_s - a_1*v", "mu_s a_1",
     "near one belt speed; negative beyond v = mu_s/a_1",
     "linearisation, textbook", _OF_LINEAR),
    LawEntry("exponential", "mu_m + (mu_s - mu_m)*exp(-alpha*v)", "mu_s mu_m alpha",
     "dry contacts; falls at all speeds if mu_s > mu_m",
     "Won & Chung 2016, eq. (3); earlier Tustin 1947" + _UNCONFIRMED),
    LawEntry("exponential_viscous", "mu_k + (mu_s - mu_k)*exp(-alpha*v) + mu_v*v", "mu_s mu_k alpha mu_v",
     "lubricated contacts through the Stribeck dip; falls at first if alpha (mu_s - mu_k) > mu_v",
     "Tustin 1947" + _UNCONFIRMED),
    LawEntry("gaussian", "mu_m + (mu_s - mu_m)*exp(-(v/v_s)^2)", "mu_s mu_m v_s",
     "lubricated metals; flat at v = 0+, steepest at v_s/sqrt(2), constant beyond 2 v_s",
     "Armstrong-Helouvry 1991" + _UNCONFIRMED),
    LawEntry("gaussian_viscous", "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^2) + mu_v*v", "mu_s mu_k v_s mu_v",
     "steady sliding of the LuGre model; rises with mu_v at v = 0+, dips, and rises again",
     "Canudas de Wit, Olsson, Astrom & Lischinsky 1995" + _UNCONFIRMED),
    LawEntry("stribeck", "mu_m + (mu_s - mu_m)*exp(-(v/v_s)^delta)", "mu_s mu_m v_s delta",
     "any Stribeck curve without viscous rise; the slope at v = 0+ is infinite for delta < 1",
     "Bo & Pavelescu 1982" + _UNCONFIRMED),
    LawEntry("stribeck_viscous", "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^delta) + mu_v*v", "mu_s mu_k v_s delta mu_v",
     "dry to fully lubricated steady friction; the slope at v = 0+ is infinite for delta < 1",
     "Armstrong-Helouvry, Dupont & Canudas de Wit 1994" + _UNCONFIRMED),
    LawEntry("lorentzian", "mu_m + (mu_s - mu_m)/(1 + (v/v_s)^2)", "mu_s mu_m v_s",
     "mixed lubrication; flat at v = 0+, steepest at v_s/sqrt(3), algebraic tail",
     "Hess & Soom 1990, without its viscous term" + _UNCONFIRMED),
    LawEntry("lorentzian_viscous", "mu_k + (mu_s - mu_k)/(1 + (v/v_s)^2) + mu_v*v", "mu_s mu_k v_s mu_v",
     "lubricated line contacts from boundary to full film; dips if mu_v < 0.65 (mu_s - mu_k)/v_s",
     "Hess & Soom 1990" + _UNCONFIRMED),
    LawEntry("hyperbolic", "mu_m + (mu_s - mu_m)/(1 + v/v_s)", "mu_s mu_m v_s",
     "dry contacts with a slow fall, such as rosin, rubber or brake blocks",
     "Bochet 1861; for stick-slip oscillators Popp & Stelter 1990" + _UNCONFIRMED),
    LawEntry("popp_stelter", "mu_k + (mu_s - mu_k)/(1 + v/v_s) + beta*v^2", "mu_s mu_k v_s beta",
     "dry friction oscillators; falls, then rises; not to be extrapolated",
     "Popp & Stelter 1990; Hinrichs, Oestreich & Popp 1998" + _UNCONFIRMED),
    LawEntry("polynomial", "mu_s - 3*(mu_s - mu_m)/(2*v_m)*v + (mu_s - mu_m)/(2*v_m^3)*v^3", "mu_s mu_m v_m",
     "up to a little beyond the minimum at v_m; passes mu_s again at sqrt(3) v_m",
     "Thomsen & Fidlin 2003; Won & Chung 2016, eq. (4)"),
    LawEntry("quintic", "mu_s + a_1*v + a_3*v^3 + a_5*v^5", "mu_s a_1 a_3 a_5",
     "a fit, inside the fitted speeds only",
     "odd polynomial, as in oscillators of van der Pol's and Rayleigh's kind"),
    LawEntry("cubic", "mu_s + a_1*v + a_2*v^2 + a_3*v^3", "mu_s a_1 a_2 a_3",
     "a fit, inside the fitted speeds only",
     "polynomial fit, as for robot joints in Visioli & Legnani 2002" + _UNCONFIRMED),
    LawEntry("logarithmic", "mu_s - b_a*log(1 + v/v_c)", "mu_s b_a v_c",
     "steady rate-and-state weakening (b > a), cut off below v_c; negative at extreme speeds",
     "Dieterich 1979, Ruina 1983; the cut-off is this package's"),
    LawEntry("arcsinh", "mu_s - b_a*asinh(v/(2*v_c))", "mu_s b_a v_c",
     "as the logarithmic law, analytic at v = 0",
     "after the regularisation of Rice & Ben-Zion 1996; applied to b - a it is this package's"),
    LawEntry("arctangent", "mu_s - (mu_s - mu_m)*2/pi*atan(v/v_s)", "mu_s mu_m v_s",
     "a saturating fall with an algebraic tail, empirical",
     "of no one author"),
    LawEntry("tanh", "mu_s - (mu_s - mu_m)*tanh(v/v_s)", "mu_s mu_m v_s",
     "a saturating fall without curvature at v = 0+, empirical",
     "of no one author"),
    LawEntry("sech", "mu_m + (mu_s - mu_m)*sech(v/v_s)", "mu_s mu_m v_s",
     "a Stribeck drop, flat at v = 0+, with an exponential tail",
     "Feeny & Moon 1994, without its smoothing factor" + _UNCONFIRMED),
    LawEntry("two_exponentials", "mu_m + d_1*exp(-v/v_1) + d_2*exp(-v/v_2)", "mu_m d_1 v_1 d_2 v_2",
     "rosin on a bow, and any curve with a fast and a slow drop",
     "Smith & Woodhouse 2000" + _UNCONFIRMED),
    LawEntry("kragelskii", "(a_0 + a_1*v)*exp(-alpha*v) + a_2", "a_0 a_1 alpha a_2",
     "dry solids; with a maximum at v > 0 if a_1 > alpha a_0",
     "Kragelskii 1965" + _UNCONFIRMED, _OF_KRAGELSKII),
    LawEntry("rational", "(0.5 + 0.3*v/v_s + 0.25*(v/v_s)^2)/(1 + v/v_s + (v/v_s)^2)", "v_s",
     "an example of a fitted ratio of polynomials with numbers for coefficients",
     "this package"),
    # Smoothed laws, mu(0) = 0: no jump, hence no stick, only slow creep.
    LawEntry("andersson", "(mu_k + (mu_p - mu_k)*exp(-(v/v_s)^delta))*tanh(v/v_0) + mu_v*v",
     "mu_p mu_k v_s delta v_0 mu_v",
     "simulation without a stick state; needs v_0 far below v_s",
     "Andersson, Soderberg & Bjorklund 2007"),
    LawEntry("brown_mcphee", "mu_k*tanh(4*v/v_b) + (mu_p - mu_k)*(v/v_b)/((v/v_b)^2/4 + 3/4)^2 + mu_v*v",
     "mu_p mu_k v_b mu_v",
     "multibody simulation; the maximum, about mu_p, lies near v_b",
     "Brown & McPhee 2016"),
    LawEntry("simscape",
     "sqrt(2*exp(1))*(mu_p - mu_k)*exp(-(v/(sqrt(2)*v_b))^2)*v/(sqrt(2)*v_b) + mu_k*tanh(10*v/v_b) + mu_v*v",
     "mu_p mu_k v_b mu_v",
     "simulation without a stick state; the maximum, about mu_p, lies at v_b",
     "MathWorks, Simscape block Translational Friction"),
    LawEntry("bengisu_akay", "(1 - exp(-v/v_0))*(mu_k + (mu_p - mu_k)*exp(-alpha*v))", "mu_p mu_k v_0 alpha",
     "simulation without a stick state; needs alpha v_0 far below 1",
     "Bengisu & Akay 1994" + _UNCONFIRMED),
)  # fmt: skip
"""Every law of the catalogue."""
