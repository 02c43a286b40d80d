"""One preparation of a log: one fine grid, one band for torque and motion, chosen from positions."""
