"""What is computed: oscillators and structures with gaps, restitution, loads and records, units, distributions."""
