"""Fields as drawings and as an animation, and the page of a run."""
