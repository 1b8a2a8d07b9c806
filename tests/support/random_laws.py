"""Random laws of one term or two: powers of what vanishes at rest, steps, bumps, kinks and layers."""

import numpy as np

VANISHING = [
    "v",
    "1 - exp(-v)",
    "tanh(v)",
    "log(1 + v)",
    "1 - 1/(1 + v)",
    "v/(1 + v^2)",
    "atan(v)",
    "sqrt(1 + v) - 1",
]
"""Functions that vanish at rest, of which powers are taken."""
FALLING = ["exp(-v)", "1/(1 + v)", "(1 + v)^(-0.7)", "1/(1 + v^3)", "exp(-v^1.37)", "1/(1 + v^1.4)",
           "1/sqrt(1 + v + v^2)", "log(1 + v)/(1 + v)", "sech(v)", "exp(-v^2)", "1 - atan(v)"]  # fmt: skip
FEATURES = ["exp(-((v - 1)/{w})^2)", "tanh((v - 1)/{w})", "Max(1 - v/{w}, 0)", "exp(-v/{w})", "tanh(v/{w})"]
"""What varies within w, from 0.1 to 100."""


def random_law(seed):
    """Return a law of one term, or of two."""
    rng = np.random.default_rng(seed)
    factors = [str(rng.choice(FALLING))]
    if rng.random() < 0.6:
        factors.append(f"({rng.choice(VANISHING)})^{rng.choice(['0.4', '0.7', '1.5', '(1/3)', '2', '3'])}")
    if rng.random() < 0.3:
        factors.append(rng.choice(FEATURES).format(w=f"{10 ** rng.uniform(-1, 2):.3g}"))
    text = "*".join(f"({factor})" for factor in factors)
    return f"0.3*{text} + 0.1*{rng.choice(FALLING)}" if rng.random() < 0.3 else text
