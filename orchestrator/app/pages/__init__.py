"""The pages of the workbench, one a file, and what they are built of."""
