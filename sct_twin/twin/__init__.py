"""The digital twin of the test: upsetting, heat of sliding, and the loads that follow from them."""
