"""From raw channels to the sliding phase: filters, zeros, motion, phases, uncertainty."""
