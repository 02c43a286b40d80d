"""`python -m oed`: the command `oed`."""

from oed.commands.main import main

main()
