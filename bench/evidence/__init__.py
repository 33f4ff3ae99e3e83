"""The parts of `bench/paper.py`: one study of the paper's evidence each, and what draws and writes them."""
