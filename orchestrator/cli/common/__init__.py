"""What commands share: options, console, interrupts, the files that a command names."""
