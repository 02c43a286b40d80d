"""Draw every figure: python -m paper_figures."""

from paper_figures.writing import write_all

for file in write_all():
    print(file)
