"""What every result is made of: the door to the core, tables, namelists, events, states, and the base classes."""
