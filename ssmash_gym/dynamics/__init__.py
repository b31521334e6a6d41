"""How it moves: compiled kernels, one file per force element. Numbers in, numbers out."""
