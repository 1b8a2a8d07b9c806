"""The share of initial conditions that come to rest, by pyBasin beside ours: its time and its value.

Run ``python tests/benchmarks/measure_pybasin.py [COUNT] [PYTHON]``; 200 of them if no other count is given.

pyBasin 0.2.0 needs Python 3.12 and PyTorch, so it is no dependency: PYTHON is the interpreter of an environment
that has it, by default the one that runs this; without pyBasin there it is skipped. The system is the bistable one
of its own friction case: m = k = N = 1, c = 0.1, V = 1.5, mu = 0.5 + 0.5 exp(-2 v), with x from -2 to 2 and v from
0 to 2. As there, the sign of the slip speed is smoothed, by tanh(50 v), a run takes 500 units of time with
tolerances 1e-8 and 1e-6, and its last fifth tells whether the mass is at rest, by the nearer of two runs whose
fate is known.
"""

import importlib.util
import json
import subprocess
import sys
import time

import numpy as np

MASSES = {"V": 1.5, "c": 0.1, "mu_s": 1.0, "mu_m": 0.5, "alpha": 2.0, "sharpness": 50.0}
BOX = ((-2.0, 2.0), (0.0, 2.0))  # of x and of v
KNOWN = {"rest": [1.0, 1.0], "stick-slip": [2.0, 2.0]}
END, LATE, SAVED = 500.0, 400.0, 500
SEED = 1


def by_pybasin(count):
    """Return the share, its standard error, and the seconds, in all and of the processor."""
    import torch
    from pybasin import BasinStabilityEstimator, set_seed
    from pybasin.feature_extractors.feature_extractor import FeatureExtractor
    from pybasin.sampler import UniformRandomSampler
    from pybasin.solvers import ODESystem, TorchDiffEqSolver
    from pybasin.template_integrator import TemplateIntegrator
    from sklearn.neighbors import KNeighborsClassifier

    class Belt(ODESystem):
        def ode(self, t, y, p):
            V, c, mu_s, mu_m, alpha, sharpness = (p[..., place] for place in range(len(MASSES)))
            x, v = y[..., 0], y[..., 1]
            slip = V - v
            mu = mu_m + (mu_s - mu_m) * torch.exp(-alpha * torch.abs(slip))
            return torch.stack([v, mu * torch.tanh(sharpness * slip) - c * v - x], dim=-1)

    class Fastest(FeatureExtractor):
        def extract_features(self, solution):
            return torch.abs(self.filter_time(solution)[..., 1]).max(dim=0).values[:, None]

    set_seed(SEED)
    low, high = (list(ends) for ends in zip(*BOX, strict=True))
    solver = TorchDiffEqSolver(t_span=(0, END), t_steps=SAVED, rtol=1e-8, atol=1e-6, device="cpu", cache_dir=None)
    estimator = BasinStabilityEstimator(
        Belt(MASSES),
        UniformRandomSampler(low, high, device="cpu"),
        n=count,
        solver=solver,
        feature_extractor=Fastest(time_steady=LATE),
        predictor=KNeighborsClassifier(n_neighbors=1),
        template_integrator=TemplateIntegrator(list(KNOWN.values()), list(KNOWN), MASSES),
        feature_selector=None,
    )
    begin, begin_cpu = time.perf_counter(), time.process_time()
    found = estimator.run()
    times = time.perf_counter() - begin, time.process_time() - begin_cpu
    return found["basin_stability"].get("rest", 0.0), found["errors"]["rest"]["e_abs"], *times


def by_areas():
    """Return the same by `basin_map`."""
    import stickslip_sym as ss

    law = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
    osc = ss.Oscillator(m=1, k=1, c=MASSES["c"], V=MASSES["V"], N=1)
    times = []
    for _ in range(5):
        begin, begin_cpu = time.perf_counter(), time.process_time()
        share = ss.basin_map(law, osc, x0=np.array(BOX[0]), v0=np.array(BOX[1])).share[ss.Motion.REST]
        times.append((time.perf_counter() - begin, time.process_time() - begin_cpu))
    return share.value, share.error, *min(times, key=lambda both: both[1])


def main(count, python):
    """Print both, the time as it passed and of the processor."""
    done = subprocess.run([python, __file__, "--peer", count], capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"skipped: {done.stderr.strip().splitlines()[-1]}")
        return
    peer, ours = json.loads(done.stdout.splitlines()[-1]), by_areas()
    for name, (share, error, seconds, cpu) in ((f"pyBasin, {count} motions", peer), ("areas", ours)):
        print(f"{name:20} {share:.11f} +- {error:.1g} in {seconds:.3g} s, {cpu:.3g} s of the processor")
    off = abs(peer[0] - ours[0]) / peer[1]
    print(f"{peer[3] / ours[3]:.3g} times the time of the processor, and {off:.1f} of its standard errors off")


if __name__ == "__main__":
    if sys.argv[1:2] != ["--peer"]:
        main(*sys.argv[1:3], *("200", sys.executable)[len(sys.argv) - 1 :])
    elif importlib.util.find_spec("pybasin") is None:
        sys.exit(f"pyBasin is not in the environment of {sys.executable}; give the interpreter of one that has it")
    else:
        print(json.dumps(by_pybasin(int(sys.argv[2]))))
