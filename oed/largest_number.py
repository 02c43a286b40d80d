"""The largest numbers that a user's file or option may hold."""

# No joint quantity in SI units comes near, nor do seconds since 1970, and no part of an arm is a ten
# thousandth of it: beyond it, a unit is wrong. Products of four still are numbers.
LARGEST = 1e10
# Of gravity, in any direction [m/s^2]: on Jupiter, more than on every other planet, it is 24.8 (NASA's
# planetary fact sheet). A number beyond is in another unit, such as cm/s^2.
MOST_GRAVITY = 25.0
