"""Proofs about motions in ball arithmetic (extra `proof`): existence, uniqueness, verdicts."""
