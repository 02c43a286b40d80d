"""One script a figure of the paper: each reads results and asserts what its caption claims."""
