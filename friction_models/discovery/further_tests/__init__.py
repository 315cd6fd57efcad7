"""Which further tests would tell rival effects apart."""
