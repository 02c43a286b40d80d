"""From recorded torques to parameters with honest uncertainty."""
