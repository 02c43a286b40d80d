"""The largest number that a user's file or option may hold."""

# No joint quantity in SI units comes near, nor do seconds since 1970, and no part of an arm is a ten
# thousandth of it: beyond it, a unit is wrong. Products of four still are numbers.
LARGEST = 1e10
