"""Derivatives of motions and trajectories with respect to parameters."""
