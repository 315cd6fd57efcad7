"""The judge: what unseen tests confirm, how much of the error is explained, and how sure the verdict is."""
