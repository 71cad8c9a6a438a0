"""The Python API: data frames or a campaign in; fits, posteriors, findings, tables, plots and FMUs out."""

from haptid.support.files.cache import give_matplotlib_a_folder

give_matplotlib_a_folder()  # its axes are part of the results
