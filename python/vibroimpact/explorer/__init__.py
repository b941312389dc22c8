"""The live explorer: a page on this machine on which zones, motions and simulations follow the pointer.

`state`, `recipe`, `motions`, `zones`, `explorer` and `export` know nothing of a page and need no other library;
`shapes` turns what they give into plain arrays, `figures`, `page` and `server` draw them (extra `explorer`).
"""
