"""Proofs about zero sets: that they keep to the data, and of how many pieces and of which shape they are.

The box is divided into blocks (`restriction`), on each of which coefficients enclose f with all rounding (`blocks`).
Blocks are halved until they are settled (`subdivision`): as holding no zero, as lying near the data (`tube`), or as so
small that the zero set is simple there (`regularity`). The signs at their corners then tell its topology (`topology`).
`prover` says what has been proved.
"""
