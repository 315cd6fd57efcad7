"""The study ``lag``: what friction from the loads of the step before costs, by the size of the step.

Every run is compared at the same strokes, multiples of the longest communication step: with the iterated
run of its own step, which differs by the lag alone, and with the iterated run of the finest step.
"""
