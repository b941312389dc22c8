"""Studies of many motions: branches along a parameter, and zones in the plane (r, d K/F0)."""
