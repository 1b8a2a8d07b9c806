"""Fast functions as source text of other languages, and as loops that a C compiler makes at once.

One more language is one file here that supplies what `languages.Language` says, and its line in the table there;
one outside the package is `languages.register(name, language, description)`.
"""
