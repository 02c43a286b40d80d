"""One thin script per question: a frozen configuration, run to rows, write to results/.

The method lives in `oed`; nothing imports a study. Run one with `python -m studies.NAME`.
"""
