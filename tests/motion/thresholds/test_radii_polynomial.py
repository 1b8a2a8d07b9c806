"""Proved thresholds against a proof of another kind: the grazing orbit as a fixed point, by a radii polynomial."""

from fractions import Fraction

import pytest
from flint import fmpq

import stickslip_sym as ss
from stickslip_sym.criteria.enclosure import Enclosure, enclosure_of
from support import radii_polynomial as independent

ETA = fmpq(981, 500)  # N/(V sqrt(k m))
FRICTION = {
    "exponential": independent.Exponential(fmpq(3, 10), fmpq(3, 2)),
    "polynomial": independent.Cubic(fmpq(9, 40), fmpq(3, 160)),
}
POINT = {"V": "0.5", "N": "9.81", "m": 1, "k": 100}


def enclosed(proof):
    """Return what the damping in kg/s lies in: sqrt(k m) is 10 kg/s."""
    return enclosure_of(10 * proof.damping)


@pytest.mark.parametrize("name", FRICTION)
def test_the_only_orbit_has_the_proved_threshold(name):
    proof = independent.prove(FRICTION[name], ETA)
    assert proof.first_return
    assert proof.Y + (proof.Z1 + proof.Z2 * proof.radius) * proof.radius < proof.radius
    orbit = enclosed(proof)
    assert orbit.high - orbit.low < Fraction(1, 10**11)
    law = ss.laws.catalogue[name].typical()
    proved = ss.pure_slip_damping(law, **POINT, method="proof", rtol=1e-15).enclosure
    assert proved.overlaps(orbit)
    for shift in (-1, 1):  # a threshold that is off by 1e-12 is told from it
        factor = 1 + Fraction(shift, 10**12)
        assert not Enclosure(proved.low * factor, proved.high * factor).overlaps(orbit)


@pytest.mark.parametrize("name", FRICTION)
def test_nothing_is_proved_of_what_is_no_orbit(name):
    with pytest.raises(ArithmeticError, match="no radius"):
        independent.prove(FRICTION[name], ETA, shift=1e-6)


def test_another_law_has_another_orbit():
    wrong = independent.prove(independent.Exponential(fmpq(3, 10), fmpq(1501, 1000)), ETA)
    assert not enclosed(wrong).overlaps(enclosed(independent.prove(FRICTION["exponential"], ETA)))
