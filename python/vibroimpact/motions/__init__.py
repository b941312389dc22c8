"""Motions and trajectories: periodic, exact and simulated, and their response quantities."""
