"""The parts that all results share: the interface to the core, tables, namelists, events, states and base
classes."""
