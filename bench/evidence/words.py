"""What bench/PAPER.md says around its tables and figures."""

TITLE = ""
BEFORE = dict.fromkeys(("growth", "adaptive", "families", "instability", "cost", "noise"), "")
AFTER = BEFORE
