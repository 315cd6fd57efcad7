"""Force-stroke curves of press and simulation, and the error measures between them."""
