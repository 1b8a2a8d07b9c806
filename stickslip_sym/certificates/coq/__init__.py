"""Closed forms as scripts for the proof assistant Coq, over Coquelicot.

`words` writes formulas as Coq has them, `printer` prints them, `script` states equations that its tactic `field`
proves; `integral` and `slope` fill the parts of `template.v`, and take what lemmas they need from `library.v`.
"""
