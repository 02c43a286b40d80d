"""`python -m studies.bench`."""

from studies.bench.study import main

if __name__ == "__main__":
    main()
