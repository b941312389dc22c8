"""Results on their way to other programs and back, a file a form.

`result` has the methods that all results inherit; `plain` makes plain values of a result (for JSON) and
checks those that are read; `dataset` is xarray and netCDF, `table` CSV and pandas, `matlab` .mat files,
`namelist` the case that gives the result again, and `page` what Jupyter shows.
"""
