"""A blind benchmark of the diagnosis: laws of the literature on rigs and plans as laboratories have them.

Written from the contracts and the literature, without a look at the code that is judged. See README.md.
"""
