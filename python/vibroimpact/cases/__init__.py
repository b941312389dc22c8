"""Namelists: cases as objects, and files of cases that are run."""
