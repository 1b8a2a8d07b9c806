"""Laws and operating points that several test files use."""

import numpy as np

import stickslip_sym as ss

TWO = ss.FrictionLaw("0.4 - 0.3*(v - 0.5) - 2*(v - 0.5)^3 + 8*(v - 0.5)^5")  # mu' about V = 0.5 in even powers
WAVY = ss.FrictionLaw("a+b*exp(-v/s)+h*cos(w*v)*exp(-(v/q)**2)").bind(
    a=0.323, b=0.1724, s=0.7627, h=0.01072, w=55.28, q=1.1416
)
WAVY_POINT = ss.Oscillator(m=4.396, k=7.314, c=0.0855, V=0.4468, N=0.626786)


def paper_oscillator(c=0.0, **changes):
    """Return the oscillator of the paper's section 3."""
    return ss.Oscillator(**({"m": 1.0, "k": 100.0, "c": c, "V": 0.5, "N": 9.81} | changes))


def laws_in_pieces(rng, count):
    """Return laws with kinks, through measured points, or with a static coefficient above mu(0+)."""

    def measured():
        v = np.r_[0, np.sort(rng.uniform(0.05, 2, int(rng.integers(4, 16)) - 1))]
        mu = 0.2 + 0.3 * np.exp(-rng.uniform(1, 5) * v) + rng.uniform(0, 0.03) * rng.standard_normal(v.size)
        return ss.FrictionLaw.from_samples(v.round(6), mu.round(6), extrapolate=True)

    def kinked():
        places, (fall, rise) = np.sort(rng.uniform(0.05, 1.2, 2)), rng.uniform((0.05, -0.1), (0.4, 0.2))
        return ss.FrictionLaw(f"0.5 - {fall:.4f}*Min(v, {places[0]:.4f}) + {rise:.4f}*Max(v - {places[1]:.4f}, 0)")

    def held():
        return ss.laws.exponential.typical(alpha=rng.uniform(0.5, 6)).with_static(rng.uniform(0.5, 0.6))

    def bent():
        slope, place = rng.uniform((0.02, 0.05), (0.2, 0.9))
        return ss.FrictionLaw(f"0.4 - {slope:.4f}*Abs(v - {place:.4f})", static="0.6")

    return [(measured, kinked, held, bent)[i % 4]() for i in range(count)]


SMOOTH = [
    "exponential", "polynomial", "hyperbolic", "gaussian", "lorentzian", "tanh", "brown_mcphee", "logarithmic",
]  # fmt: skip


def smooth_points(rng, count, **decades):
    """Yield smooth laws of the catalogue, their parameters off by up to a quarter, and operating points."""
    decades = {"V": (-1.3, 0), "N": (-1, 1.3), "m": (-1, 1), "k": (1.5, 4)} | decades
    for number in range(count):
        law = ss.laws.catalogue[SMOOTH[number % len(SMOOTH)]].typical()
        law = law.bind(**{name: float(value) * 10 ** rng.uniform(-0.1, 0.1) for name, value in law.values.items()})
        yield law, {name: 10 ** rng.uniform(*ends) for name, ends in decades.items()}
