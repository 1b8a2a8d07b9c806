"""Terms of a law, integrated by rules, each with the theorem that proves it.

One more family of terms is one rule in `antiderivatives` (polynomial weights) or in `harmonic_rules`.
"""
