"""Seeded operating points, and a reference for motions that shares nothing with `slip` but the values of mu."""

import math
from itertools import pairwise

import numpy as np
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq

import stickslip_sym as ss
from stickslip_sym import Phase

MEASURED = np.array([0, 0.03, 0.1, 0.2, 0.35, 0.5, 0.8, 1.2, 2.0, 4.0])
LAWS = {
    "exponential": ("mu_m + (mu_s - mu_m)*exp(-v/v_s)", None),
    "hyperbolic": ("mu_m + (mu_s - mu_m)/(1 + v/v_s)", None),
    "polynomial": ("mu_s - 1.5*(mu_s - mu_m)*(v/v_s - (v/v_s)^3/3)", None),
    "static jump": ("mu_m", "mu_s"),
    "smoothed": ("(mu_m + (mu_s - mu_m)*exp(-v/v_s))*tanh(20*v/v_s)", None),
    "kinked": ("Piecewise((mu_s - (mu_s - mu_m)*v/v_s, v < v_s), mu_m)", None),
    "rising": ("mu_m + 0.05*v/v_s", "mu_s"),
}
NATURAL_PERIODS = 3
ROUNDING = 1e-12
MISSED = 1e-10  # slip speed over V, a hundred times what the integration is off
KINDS = [*LAWS, "measured"]
CHECKS = 100  # of the relative velocity, within one step of the reference
REFERENCE = 1e-13  # tolerance of a step of the reference
LONGEST = 0.3  # step of the reference, over the natural period's radian
LEFT = 1e-10  # relative velocity over V above which the mass has left the belt's speed, in the reference


def points(count, seed):
    """Yield laws, oscillators and starts: groups and starts of all sizes, in odd units."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        yield kind, *_drawn(rng, kind)


def one_point(seed):
    """Return a law of any kind, an oscillator and a start."""
    rng = np.random.default_rng(seed)
    return _drawn(rng, KINDS[seed % len(KINDS)])


def _drawn(rng, kind):
    m, k, V = 10 ** rng.uniform((-3, -3, -2), (3, 3, 1))
    eta, zeta, v_s = 10 ** rng.uniform((-2, -3, -0.7), (1.2, 0.3, 1.3))
    impedance = math.sqrt(k * m)
    # A fourth of the masses is driven, by a weak negative damping.
    c = 2 * zeta * impedance * rng.choice((1, 1, 1, -0.02))
    osc = ss.Oscillator(m=m, k=k, V=V, N=eta * V * impedance, c=c)
    mu_m = rng.uniform(0.05, 0.5)
    mu_s = mu_m + rng.uniform(0.02, 0.5)
    return bound(kind, mu_m, mu_s, v_s * V), osc, *start(rng, osc, mu_s)


def bound(kind, mu_m, mu_s, v_s):
    if kind == "measured":
        mu = mu_m + (mu_s - mu_m) * np.exp(-MEASURED)
        return ss.FrictionLaw.from_samples(v_s * MEASURED, mu, extrapolate=True)
    formula, static = LAWS[kind]
    law = ss.FrictionLaw(formula, static=static)
    values = {"mu_m": mu_m, "mu_s": mu_s, "v_s": v_s}
    return law.bind(**{name: values[name] for name in law.parameters})


def start(rng, osc, mu_s):
    x0 = (rng.uniform(-1.5, 1.5) * mu_s * osc.N - osc.c * osc.V) / osc.k + rng.normal() * osc.length
    return x0, osc.V * (1 if rng.random() < 0.3 else 1 + rng.normal() * 1.5)


def violations(law, osc, motion, missed=MISSED):
    """Return what is wrong with a motion in itself: missed and spurious events, and sticks that cannot be."""
    found = []
    static = float(law.mu(0.0) if law.static is None else law.number(law.static))
    for event, stretch in zip(motion.events, motion.stretches, strict=False):
        samples = motion.t[(motion.t >= stretch.start) & (motion.t <= stretch.end)]
        t = np.interp(np.arange(CHECKS * (samples.size - 1) + 1) / CHECKS, np.arange(samples.size), samples)
        x, v = stretch.course(t)
        if stretch.phase is Phase.STICK:
            if abs(osc.c * osc.V + osc.k * x[0]) > static * osc.N * (1 + ROUNDING):
                found.append(f"static friction cannot hold the mass from {event.t:g} s on")
            if not np.all(v == osc.V):
                found.append(f"stick from {event.t:g} s on is not at the belt's speed")
            continue
        height = (osc.V - v) / osc.V * (1 if stretch.phase is Phase.SLIP_BACK else -1)
        if height.min() < -missed * max(1.0, height.max()):
            found.append(f"an event is missed after {event.t:g} s: w comes down to {height.min():.1e}")
        if height.max() < missed and stretch.end < motion.t[-1]:
            found.append(f"an event is spurious: from {event.t:g} s on w rises to {height.max():.1e} only")
    return found


def disagreement(events, expected):
    """Return by how much the times of two lists of events differ, relatively; infinity where the lists do."""
    if [event.begins for event in events] != [phase for _, phase in expected]:
        return math.inf
    times = [(event.t, t) for event, (t, _) in zip(events[1:], expected[1:], strict=True)]
    return max((abs(ours / t - 1) for ours, t in times), default=0.0)


def reference(law, osc, x0, v0, t_end):
    """Return the changes of phase as (time, phase), by DOP853 in SI units."""
    mu, mu_0 = law.function("math"), float(law.mu(0.0))
    static = mu_0 if law.static is None else law.number(law.static)
    level = static * osc.N
    t, x, v = 0.0, x0, v0
    found = []
    while t < t_end:
        pull = osc.k * x + osc.c * osc.V
        if v == osc.V and abs(pull) < level * (1 - 1e-13):
            found.append((t, Phase.STICK))
            t, x = t + ((level - osc.c * osc.V) / osc.k - x) / osc.V, (level - osc.c * osc.V) / osc.k
            continue
        side = (1 if pull > 0 else -1) if v == osc.V else (1 if v < osc.V else -1)
        found.append((t, Phase.SLIP_BACK if side > 0 else Phase.SLIP_FORWARD))
        t, (x, _) = slip(mu, mu_0, osc, side, t, x, v, t_end, law.kinks())
        v = osc.V
    return found


def slip(mu, mu_0, osc, side, t, x, v, t_end, kinks):
    """Return when and where the mass comes back to the belt's speed; begin anew at every kink of mu."""

    def rates(_, y):
        slip_speed = side * (osc.V - y[1])
        friction = side * osc.N * (mu(slip_speed) if slip_speed > 0 else mu_0)
        return [y[1], (friction - osc.c * y[1] - osc.k * y[0]) / osc.m]

    def integrator(t, y, end, **options):
        return DOP853(rates, t, y, end, rtol=REFERENCE, atol=REFERENCE * np.array((osc.length, osc.V)), **options)

    def gap(v):
        return side * (osc.V - v) / osc.V

    def passage(before, state, course, level, a, b):
        root = brentq(lambda s: gap(course(s)[1]) - level, a, b, xtol=1e-300, rtol=1e-15)
        for _ in range(2):  # the integration is more accurate than its interpolant
            if root <= before:
                return before, state
            fresh = integrator(before, state, root, first_step=root - before)
            while fresh.status == "running":
                fresh.step()
            slope = rates(0, fresh.y)
            shift = (level - gap(fresh.y[1])) / (-side * slope[1] / osc.V)
            if abs(shift) > 1e-6 / osc.omega:
                return root, fresh.y
            root += shift
        return root, fresh.y + shift * np.array(slope)

    levels = [0.0, *(float(kink) / osc.V for kink in kinks)]
    left, here = gap(v) > LEFT, None
    solver = integrator(t, [x, v], t_end, max_step=LONGEST / osc.omega)
    while solver.status == "running":
        before, state = solver.t, solver.y.copy()
        solver.step()
        assert solver.status != "failed"
        course = solver.dense_output()
        times = np.linspace(before, solver.t, CHECKS + 1)
        heights = gap(course(times)[1])
        heights[0] = gap(state[1])
        for i, (high, low) in enumerate(pairwise(heights)):
            left = left or high > LEFT
            if left and high > 0 >= low:
                return passage(before, state, course, 0.0, times[i], times[i + 1])
            passed = [level for level in levels[1:] if level != here and min(high, low) <= level <= max(high, low)]
            if passed:
                here = min(passed, key=lambda level: abs(level - high))
                t, y = passage(before, state, course, here, times[i], times[i + 1])
                solver = integrator(t, y, t_end, max_step=LONGEST / osc.omega)
                break
            here = here if i == 0 else None
    return math.inf, solver.y


def lsoda(law, osc, x, v, t):
    """Return x and v of a slip at ascending times, from their first, by a method of several steps, in SI units."""
    mu, side = law.function("math"), np.sign(osc.V - v)

    def rates(_, y):
        friction = side * osc.N * mu(max(side * (osc.V - y[1]), 1e-300))
        return [y[1], (friction - osc.c * y[1] - osc.k * y[0]) / osc.m]

    atol = 1e-12 * np.array((osc.length, osc.V))
    return solve_ivp(rates, (t[0], t[-1]), (x, v), method="LSODA", t_eval=t, rtol=1e-11, atol=atol).y


def simulated(law, osc, x0, v0, rtol=1e-12):
    """Return the motion over three natural periods."""
    t_end = NATURAL_PERIODS * 2 * math.pi / osc.omega
    return ss.simulate(law, osc, t_end=t_end, x0=x0, v0=v0, rtol=rtol)
