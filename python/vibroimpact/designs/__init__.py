"""The design of impact dampers: hosts, the problem, its search, and the confirmation of the result."""
