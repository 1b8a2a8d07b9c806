"""Fast functions as source text of other languages.

One more language is one file like `c_text`, with its dialect in `dialects`.
"""
