"""The FMU runtime: FMUs are unpacked, loaded, isolated and called; friction FMUs serve as models."""
