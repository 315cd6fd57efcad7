"""Which loads of a forming process were never tested, and which tests would cover them."""
