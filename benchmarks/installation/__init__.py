"""What the program needs on a computer: disk, memory, wheels, and kernels on 64-bit ARM."""
