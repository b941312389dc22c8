"""Motions and trajectories: periodic, exact and simulated ones, and the quantities taken from them."""
