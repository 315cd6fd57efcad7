"""The virtual rig: sensors, motion, data logger, specimen."""
