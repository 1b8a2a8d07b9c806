"""What the oscillator does, by computations that share nothing with closed forms.

Its packages are `kernel`, `simulation`, `orbits`, `thresholds`, `margins`, `regimes` and `maps`, each importing
from those before it and from `core`, `output`, `model` and `criteria`. One arrow crosses from here to `formula`:
thresholds take averages of slopes from `formula.evaluation`.
"""
