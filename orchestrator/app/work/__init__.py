"""Commands at work, in processes beside the server."""
