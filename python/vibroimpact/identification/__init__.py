"""The steps of an identification: from records of a rig to its parameters."""
