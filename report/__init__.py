"""Results in, figures and pages out; computes nothing."""

from haptid.support.files.cache import give_matplotlib_a_folder

give_matplotlib_a_folder()  # all figures are drawn below
