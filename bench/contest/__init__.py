"""The parts of `bench/peers.py`: one contest each, what runs a contender, and what words stand round the tables."""
