"""Effects of contact pressure and surface expansion: real contact area, thinning film. They see `base`, `parameters` and `expressions`.

What pressure does to a film of lubricant at speed is in `speed/viscous.py` and `speed/hersey.py`.
"""
