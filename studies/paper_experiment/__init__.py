"""The paper's experiment, whole: its trajectories, campaigns, Monte Carlo, claims and tables."""
