"""The pictures of the gallery: ``python stickslip_sym/docs/gallery.py FOLDER`` draws them."""

import sys
from pathlib import Path

import numpy as np

import stickslip_sym as ss


def draw(folder: Path) -> None:
    """Draw the five pictures into a folder."""
    law = ss.laws.exponential.typical()
    osc = ss.Oscillator(m=1.0, k=100.0, c=2.3, V=0.5, N=9.81)
    x, y = ("V", np.linspace(0.02, 1, 40)), ("c", np.linspace(0, 6, 40))
    ss.motion_map(law, m=osc.m, k=osc.k, N=osc.N, x=x, y=y).plot(folder / "map.svg")
    ss.simulate(law, osc, t_end=5.0, x0=0.0).plot(folder / "motion.svg")
    ss.regime(law, osc).plot(folder / "regime.svg")
    weak = ss.laws.exponential.bind(mu_s=1.0, mu_m=0.5, alpha=2.0)
    belt = ss.Oscillator(m=1.0, k=1.0, c=0.1, V=1.5, N=1.0)
    ss.basin_map(weak, belt, x0=np.linspace(-2, 2, 200), v0=np.linspace(0, 2, 200)).plot(folder / "basins.svg")
    v = np.geomspace(0.005, 2, 60)
    mu = law.mu(v) + 0.005 * np.random.default_rng(1).normal(size=v.size)
    ss.fit(v, mu, laws=["exponential", "hyperbolic"]).plot(folder / "fit.svg")


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
