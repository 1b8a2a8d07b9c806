"""Basins of attraction over a plane of starts."""

import numpy as np
import pytest
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.slip import Dimensionless


def test_basins_of_rest_and_stick_slip(tmp_path):
    law, osc = ss.laws.exponential.typical(), paper_oscillator(2.3)
    x0, v0 = np.linspace(-0.05, 0.08, 5), [-0.3, 0.0, 0.5, 0.8]
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert found.motion.shape == (4, 5)
    for row, v in enumerate(v0):
        assert found.motion[row].tolist() == [ss.classify(law, osc, x0=x, v0=v) for x in x0]
    assert set(found.count()) == {Motion.STICK_SLIP, Motion.REST}
    # The separatrix is the unstable cycle: starts well inside come to rest, those outside do not.
    (curve,) = found.regime.separatrices
    centre = found.regime.rest.x
    ends = np.array([curve.x.min(), curve.x.max()])
    for scale, expected in ((0.9, Motion.REST), (1.1, Motion.STICK_SLIP)):
        assert ss.basin_map(law, osc, x0=centre + scale * (ends - centre), v0=[0.0]).count() == {expected: 2}
    found.to_csv(tmp_path / "basins.csv")
    assert len((tmp_path / "basins.csv").read_text().splitlines()) == 1 + 20
    found.to_npz(tmp_path / "basins.npz")
    with np.load(tmp_path / "basins.npz", allow_pickle=False) as arrays:
        assert (arrays["fixed_c"], arrays["motion"].shape) == (2.3, (4, 5))
    found.plot(tmp_path / "basins.svg")
    assert ">separatrix</text>" in (tmp_path / "basins.svg").read_text()


def test_pure_slip_draws_every_start():
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.1)
    assert ss.basin_map(law, osc, x0=[-0.1, 0.0, 0.1], v0=[0.0, 0.5]).count() == {Motion.PURE_SLIP: 6}
    with pytest.raises(ss.InputError, match="x0 holds a value that is not finite: inf"):
        ss.basin_map(law, osc, x0=[float("inf")], v0=[0.0])


def test_the_slip_from_P_is_not_integrated_for_each_initial_condition(monkeypatch):
    follow, counts = Dimensionless.slip, []

    def counted(system, q, w, *arguments, **options):
        counts[-1] += q == w == 0 and not options.get("backward")  # backward it is what leads to P
        return follow(system, q, w, *arguments, **options)

    monkeypatch.setattr(Dimensionless, "slip", counted)
    for count in (2, 20):
        counts.append(0)
        osc = paper_oscillator(2.3 + 1e-9 * count)  # nothing is known of it yet
        ss.basin_map(
            ss.laws.exponential.typical(), osc, x0=np.linspace(-0.05, 0.08, count), v0=np.linspace(-1, 1, 10)
        )
    assert 0 < counts[0] == counts[1] < 6


FALLING = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.3), (0.3, True))")
RISING = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.2), (0.7 - 0.1*v, v < 0.6), (0.4, True))")
UNSETTLED = {
    "mu jumps down": (FALLING, paper_oscillator(1.0)),
    "mu jumps up, and down": (RISING, paper_oscillator(1.0)),
    "damping is negative": (ss.laws.exponential.typical(), paper_oscillator(-0.5)),
    "P's orbit overtakes the belt": (
        ss.laws.exponential.typical(alpha=0.8), ss.Oscillator(m=1, k=1, c=0.01, V=1, N=0.2),
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if " up" in name or "P's" in name else pytest.mark.thorough)
        for name in UNSETTLED
    ],
)
def test_lines_of_many_starts_are_classified_as_each_would_be(name):
    """Where geometry does not settle them; a line of so many is followed together."""
    law, osc = UNSETTLED[name]
    x0, v0 = np.linspace(-5, 5, 20) * osc.length, np.array([0.4, 1.8]) * osc.V
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert found.simulated == found.motion.size
    assert not found.notes
    for row, column in np.random.default_rng(4).integers((2, 20), size=(3, 2)):
        one = ss.classify(law, osc, x0=x0[column], v0=v0[row])
        assert found.motion[row, column] is one
    assert len(found.count()) == (2 if name == "mu jumps down" else 1)
