"""The live explorer: a page on this machine on which zones, motions and simulations follow the pointer.

Three rooms, of which each knows only those above it:

- what is explored, without a page: `state` (everything follows from it; share links), `recipe` (a motion to
  the last bit), `motions`, `zones`, `explorer` (the state and what follows), `export` (namelist and Python);
- what is told: `shapes` (the zones as a chart shows them), `pictures` and `sketches` (what changes in the
  figures, as plain data), `words` (texts and tables), `latest` and `background` (what takes longer than a
  frame, in threads), `session` (one open page: what is asked of it and what it answers);
- the page (extra `explorer`): `figures` (Bokeh's chart and diagram, empty), `page` with page.html, page.css,
  page.js and sketch.js (the small figures on canvases), `server`; `process` runs all of it elsewhere.
"""
