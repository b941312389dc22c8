"""The live explorer: a local web page that updates zones, motions and simulations as the pointer moves.

Three layers, each of which uses only those listed above it:

- the model, without a page: `state` (which determines everything, and is contained in links), `definition` (how to
  recompute a motion with the same bits), `motions`, `zones`, `attenuation` (max|X|/A on a map and in a box),
  `explorer` (the state and the results), `export` (namelist and Python), `opening` (the state that shows a saved
  result);
- the messages: `shapes` (the zones as drawn in a chart), `pictures` and `sketches` (changes of the figures, as
  plain data), `words` (texts and tables), `latest` and `background` (longer computations, in threads), `session`
  (one open page: its requests and answers);
- the page (extra `explorer`): `figures` (Bokeh's chart and diagram, empty), `page` with page.html, page.css,
  page.js and sketch.js (the small figures on canvases), `server`; `process` runs all of it in another process.
"""
