"""Derivatives of motions and trajectories by parameters."""
