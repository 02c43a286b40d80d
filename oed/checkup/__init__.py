"""What is wrong with a data set, decided by tests, before anything is made of an estimate."""
