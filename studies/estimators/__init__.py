"""Estimators of dynamic parameters beside one another, on simulated arms under control."""
