"""FMUs at work: unpacked, loaded, isolated, called; friction FMUs of others as models."""
