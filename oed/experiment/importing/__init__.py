"""From a log as it is to a data set: what its columns, units and roles seem to be, and why."""
