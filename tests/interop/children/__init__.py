"""One script a client, run as ``python -m tests.interop.children.CLIENT JOB RESULT`` in a process of its own."""
