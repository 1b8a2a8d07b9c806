"""From a law and a criterion to a proved formula, its fast function, and both as text of other languages.

Its rooms are `integration`, `evaluation`, `code`, `derivation` and `export`, each importing from those before it
and from the folders below: `core`, `output`, `model`, `criteria`.
"""
