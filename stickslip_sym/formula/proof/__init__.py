"""Equations proved or refuted, the theorems that proofs use, and the gate that every proposed formula passes.

One more theorem for proofs is one callable of the type `theorems.By`.
"""
