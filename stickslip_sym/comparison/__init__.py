"""Every method for a number beside the others: its cost and its error.

Imports `core`, `output`, `model`, `criteria`, `formula` and `motion`. One more method is one row of `tradeoff`;
one more part of a study is computed in `study`, kept by `Study`, and shown by `study_page` of `views`.
"""
