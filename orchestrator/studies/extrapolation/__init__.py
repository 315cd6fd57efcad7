"""The study ``extrapolation``: how friction models behave where forming asks beyond what they were trained on.

Each model is trained twice, on all training tests and on the half of the plan with low pressure and
temperature, and each then forms twice: with loads clamped to the trained domain and without.
"""
