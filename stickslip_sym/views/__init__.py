"""What is shown of results: text, HTML for notebooks, pictures and pages.

Imports all folders but `results` and `cli`; what it shows, it takes from results as users do. The views of the
results of a folder stand in the module here of the folder's name, which is imported when one of them is first
shown. A view of one more class is a function there, registered for it in `dispatch`.
"""
