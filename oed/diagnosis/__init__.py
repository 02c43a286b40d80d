"""What a torque model lacks, by one criterion; METHOD.md is the method in words."""
