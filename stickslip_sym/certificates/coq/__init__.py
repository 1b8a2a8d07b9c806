"""Closed forms as scripts for the proof assistant Coq, over Coquelicot.

`words` writes formulas as Coq has them, `printer` prints them, `tactics` states equations that its tactic `field`
proves; `integral`, `harmonic` and `equilibrium` fill the parts of `template.v`, and take what lemmas they need
from `library.v`.
"""
