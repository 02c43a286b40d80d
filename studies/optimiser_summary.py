def write_summary(rows, out): pass
