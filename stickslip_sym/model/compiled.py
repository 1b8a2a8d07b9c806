"""mu and its slope as functions of NumPy arrays, for every law of the catalogue.

Written by tests/support/compiled_laws.py from the formulas; not to be edited. The functions are those that
`core.lambdify` would make, without SymPy.
"""

# ruff: noqa: D103, E501
# mypy: disable-error-code="no-untyped-def,no-any-return"
# fmt: off

from numpy import arcsinh, arctan, exp, log, pi, sqrt, tanh


def coulomb_mu(v, mu_k):
    return mu_k


def coulomb_slope(v, mu_k):
    return 0


def coulomb_viscous_mu(v, mu_k, mu_v):
    return mu_k + mu_v*v


def coulomb_viscous_slope(v, mu_k, mu_v):
    return mu_v


def linear_mu(v, mu_s, a_1):
    return -a_1*v + mu_s


def linear_slope(v, mu_s, a_1):
    return -a_1


def exponential_mu(v, mu_s, mu_m, alpha):
    return mu_m + (-mu_m + mu_s)*exp(-alpha*v)


def exponential_slope(v, mu_s, mu_m, alpha):
    return -alpha*(-mu_m + mu_s)*exp(-alpha*v)


def exponential_viscous_mu(v, mu_s, mu_k, alpha, mu_v):
    return mu_k + mu_v*v + (-mu_k + mu_s)*exp(-alpha*v)


def exponential_viscous_slope(v, mu_s, mu_k, alpha, mu_v):
    return -alpha*(-mu_k + mu_s)*exp(-alpha*v) + mu_v


def gaussian_mu(v, mu_s, mu_m, v_s):
    return mu_m + (-mu_m + mu_s)*exp(-v**2/v_s**2)


def gaussian_slope(v, mu_s, mu_m, v_s):
    return -2*v*(-mu_m + mu_s)*exp(-v**2/v_s**2)/v_s**2


def gaussian_viscous_mu(v, mu_s, mu_k, v_s, mu_v):
    return mu_k + mu_v*v + (-mu_k + mu_s)*exp(-v**2/v_s**2)


def gaussian_viscous_slope(v, mu_s, mu_k, v_s, mu_v):
    return mu_v - 2*v*(-mu_k + mu_s)*exp(-v**2/v_s**2)/v_s**2


def stribeck_mu(v, mu_s, mu_m, v_s, delta):
    return mu_m + (-mu_m + mu_s)*exp(-(v/v_s)**delta)


def stribeck_slope(v, mu_s, mu_m, v_s, delta):
    return -delta*(v/v_s)**delta*(-mu_m + mu_s)*exp(-(v/v_s)**delta)/v


def stribeck_viscous_mu(v, mu_s, mu_k, v_s, delta, mu_v):
    return mu_k + mu_v*v + (-mu_k + mu_s)*exp(-(v/v_s)**delta)


def stribeck_viscous_slope(v, mu_s, mu_k, v_s, delta, mu_v):
    return -delta*(v/v_s)**delta*(-mu_k + mu_s)*exp(-(v/v_s)**delta)/v + mu_v


def lorentzian_mu(v, mu_s, mu_m, v_s):
    return mu_m + (-mu_m + mu_s)/(v**2/v_s**2 + 1)


def lorentzian_slope(v, mu_s, mu_m, v_s):
    return -2*v*(-mu_m + mu_s)/(v_s**2*(v**2/v_s**2 + 1)**2)


def lorentzian_viscous_mu(v, mu_s, mu_k, v_s, mu_v):
    return mu_k + mu_v*v + (-mu_k + mu_s)/(v**2/v_s**2 + 1)


def lorentzian_viscous_slope(v, mu_s, mu_k, v_s, mu_v):
    return mu_v - 2*v*(-mu_k + mu_s)/(v_s**2*(v**2/v_s**2 + 1)**2)


def hyperbolic_mu(v, mu_s, mu_m, v_s):
    return mu_m + (-mu_m + mu_s)/(v/v_s + 1)


def hyperbolic_slope(v, mu_s, mu_m, v_s):
    return -(-mu_m + mu_s)/(v_s*(v/v_s + 1)**2)


def popp_stelter_mu(v, mu_s, mu_k, v_s, beta):
    return beta*v**2 + mu_k + (-mu_k + mu_s)/(v/v_s + 1)


def popp_stelter_slope(v, mu_s, mu_k, v_s, beta):
    return 2*beta*v - (-mu_k + mu_s)/(v_s*(v/v_s + 1)**2)


def polynomial_mu(v, mu_s, mu_m, v_m):
    return mu_s + (1/2)*v**3*(-mu_m + mu_s)/v_m**3 - 1/2*v*(-3*mu_m + 3*mu_s)/v_m


def polynomial_slope(v, mu_s, mu_m, v_m):
    return (3/2)*v**2*(-mu_m + mu_s)/v_m**3 - 1/2*(-3*mu_m + 3*mu_s)/v_m


def quintic_mu(v, mu_s, a_1, a_3, a_5):
    return a_1*v + a_3*v**3 + a_5*v**5 + mu_s


def quintic_slope(v, mu_s, a_1, a_3, a_5):
    return a_1 + 3*a_3*v**2 + 5*a_5*v**4


def cubic_mu(v, mu_s, a_1, a_2, a_3):
    return a_1*v + a_2*v**2 + a_3*v**3 + mu_s


def cubic_slope(v, mu_s, a_1, a_2, a_3):
    return a_1 + 2*a_2*v + 3*a_3*v**2


def logarithmic_mu(v, mu_s, b_a, v_c):
    return -b_a*log(v/v_c + 1) + mu_s


def logarithmic_slope(v, mu_s, b_a, v_c):
    return -b_a/(v_c*(v/v_c + 1))


def arcsinh_mu(v, mu_s, b_a, v_c):
    return -b_a*arcsinh((1/2)*v/v_c) + mu_s


def arcsinh_slope(v, mu_s, b_a, v_c):
    return -1/2*b_a/(v_c*sqrt((1/4)*v**2/v_c**2 + 1))


def arctangent_mu(v, mu_s, mu_m, v_s):
    return mu_s - (-2*mu_m + 2*mu_s)*arctan(v/v_s)/pi


def arctangent_slope(v, mu_s, mu_m, v_s):
    return -(-2*mu_m + 2*mu_s)/(pi*v_s*(v**2/v_s**2 + 1))


def tanh_mu(v, mu_s, mu_m, v_s):
    return mu_s - (-mu_m + mu_s)*tanh(v/v_s)


def tanh_slope(v, mu_s, mu_m, v_s):
    return -(1 - tanh(v/v_s)**2)*(-mu_m + mu_s)/v_s


def sech_mu(v, mu_s, mu_m, v_s):
    return mu_m + (-mu_m + mu_s)*(((1/2)*exp(v/v_s) + (1/2)*exp(-v/v_s))**(-1.0))


def sech_slope(v, mu_s, mu_m, v_s):
    return -(-mu_m + mu_s)*tanh(v/v_s)*(((1/2)*exp(v/v_s) + (1/2)*exp(-v/v_s))**(-1.0))/v_s


def two_exponentials_mu(v, mu_m, d_1, v_1, d_2, v_2):
    return d_1*exp(-v/v_1) + d_2*exp(-v/v_2) + mu_m


def two_exponentials_slope(v, mu_m, d_1, v_1, d_2, v_2):
    return -d_1*exp(-v/v_1)/v_1 - d_2*exp(-v/v_2)/v_2


def kragelskii_mu(v, a_0, a_1, alpha, a_2):
    return a_2 + (a_0 + a_1*v)*exp(-alpha*v)


def kragelskii_slope(v, a_0, a_1, alpha, a_2):
    return a_1*exp(-alpha*v) - alpha*(a_0 + a_1*v)*exp(-alpha*v)


def rational_mu(v, v_s):
    return ((1/4)*v**2/v_s**2 + (3/10)*v/v_s + 1/2)/(v**2/v_s**2 + v/v_s + 1)


def rational_slope(v, v_s):
    return (-2*v/v_s**2 - 1/v_s)*((1/4)*v**2/v_s**2 + (3/10)*v/v_s + 1/2)/(v**2/v_s**2 + v/v_s + 1)**2 + ((1/2)*v/v_s**2 + (3/10)/v_s)/(v**2/v_s**2 + v/v_s + 1)


def andersson_mu(v, mu_p, mu_k, v_s, delta, v_0, mu_v):
    return mu_v*v + (mu_k + (-mu_k + mu_p)*exp(-(v/v_s)**delta))*tanh(v/v_0)


def andersson_slope(v, mu_p, mu_k, v_s, delta, v_0, mu_v):
    return -delta*(v/v_s)**delta*(-mu_k + mu_p)*exp(-(v/v_s)**delta)*tanh(v/v_0)/v + mu_v + (1 - tanh(v/v_0)**2)*(mu_k + (-mu_k + mu_p)*exp(-(v/v_s)**delta))/v_0


def brown_mcphee_mu(v, mu_p, mu_k, v_b, mu_v):
    return mu_k*tanh(4*v/v_b) + mu_v*v + v*(-mu_k + mu_p)/(v_b*((1/4)*v**2/v_b**2 + 3/4)**2)


def brown_mcphee_slope(v, mu_p, mu_k, v_b, mu_v):
    return 4*mu_k*(1 - tanh(4*v/v_b)**2)/v_b + mu_v - v**2*(-mu_k + mu_p)/(v_b**3*((1/4)*v**2/v_b**2 + 3/4)**3) + (-mu_k + mu_p)/(v_b*((1/4)*v**2/v_b**2 + 3/4)**2)


def simscape_mu(v, mu_p, mu_k, v_b, mu_v):
    return mu_k*tanh(10*v/v_b) + mu_v*v + v*(-mu_k + mu_p)*exp(1/2)*exp(-1/2*v**2/v_b**2)/v_b


def simscape_slope(v, mu_p, mu_k, v_b, mu_v):
    return 10*mu_k*(1 - tanh(10*v/v_b)**2)/v_b + mu_v - v**2*(-mu_k + mu_p)*exp(1/2)*exp(-1/2*v**2/v_b**2)/v_b**3 + (-mu_k + mu_p)*exp(1/2)*exp(-1/2*v**2/v_b**2)/v_b


def bengisu_akay_mu(v, mu_p, mu_k, v_0, alpha):
    return (1 - exp(-v/v_0))*(mu_k + (-mu_k + mu_p)*exp(-alpha*v))


def bengisu_akay_slope(v, mu_p, mu_k, v_0, alpha):
    return -alpha*(1 - exp(-v/v_0))*(-mu_k + mu_p)*exp(-alpha*v) + (mu_k + (-mu_k + mu_p)*exp(-alpha*v))*exp(-v/v_0)/v_0
