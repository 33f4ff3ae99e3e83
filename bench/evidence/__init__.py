"""The parts of `bench/paper.py`: a module for each study, and those that draw figures and write tables."""
