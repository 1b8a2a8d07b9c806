"""Families of oscillators that have one law."""

import numpy as np
from scenes import paper_oscillator

from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.regimes.rounds import Family


def family_of(law, V, eta):
    """Return oscillators with one law, free of units."""
    scene, count = Scene.of(law, paper_oscillator()), len(V)
    edges = np.array([-np.inf, *map(float, law.kinks()), np.inf if law.v_max is None else float(law.v_max)])
    alike = (np.full(count, value) for value in (scene.static, scene.onset))
    return Family(law.by_piece(), V, eta, *alike, edges / V[:, None])
