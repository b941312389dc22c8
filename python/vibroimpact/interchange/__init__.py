"""Results on their way to other programs and back, a file a form.

`result` has the methods that all results inherit; `plain` makes plain values of a result (for JSON) and
checks those that are read; `table` has its columns (pandas too) and `csv_file` writes them, `dataset` labels
its arrays for xarray and `netcdf` writes them, `matlab` is .mat files, `chart_record` charts in these forms,
`namelist` the case that gives the result again, and `page` what Jupyter shows.
"""
