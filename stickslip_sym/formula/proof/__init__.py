"""Steps with verdicts, proofs and refutations, and `derive`, which joins them to a closed form.

One more theorem for proofs is one callable of the type `theorems.By`.
"""
