"""Contact temperature in the virtual laboratory, from closed-form kernels that the twin does not use."""
