"""Campaigns: many cases of one study, computed on threads or on a cluster, and kept in a store."""
