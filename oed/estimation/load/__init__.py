"""What an arm carries, and how many newton metres an ampere is: estimates from known and unknown loads."""
