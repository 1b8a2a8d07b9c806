"""Steps with verdicts, proofs and refutations, and `derive`, which joins them to a closed form.

One more theorem for proofs is one class with the protocol `integration.theorems.By`.
"""
