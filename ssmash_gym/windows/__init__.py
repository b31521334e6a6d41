"""Safe operating windows: sea state by heading by speed, judged by the probability of exceeding a limit.

`config` says what is swept, `cells` lays out the grid, `chunks` runs episodes, `peaks` and `criteria` say what is read
of them and judged, `sequential` decides a cell, `plan` and `sweep` run what is missing, `charts` and `page` show it.
"""
