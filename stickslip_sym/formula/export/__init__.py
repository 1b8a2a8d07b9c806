"""Criteria as documents: LaTeX with limits and verdicts, and files of code."""
