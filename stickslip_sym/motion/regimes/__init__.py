"""Every attractor of an oscillator, what parts their basins, and where an initial condition leads."""
