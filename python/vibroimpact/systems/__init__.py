"""The systems: oscillators and structures with gaps, restitution, loads and records, units, and distributions."""
