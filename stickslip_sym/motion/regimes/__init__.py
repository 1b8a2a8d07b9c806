"""Every attractor of an oscillator, what parts their basins, and where a start leads."""
