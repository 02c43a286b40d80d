"""Lines that are changed on purpose, to see that the tests of a claim notice it."""
