"""Results in, figures and pages out; computes nothing."""

from haptid.support.installing.environment import ready

ready()

from haptid.support.files.cache import give_matplotlib_a_folder  # noqa: E402 # needs the packages that `ready` demands

give_matplotlib_a_folder()  # all figures are drawn below
