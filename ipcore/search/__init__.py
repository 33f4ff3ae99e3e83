"""The search for the degree: what a fit is, how close it is, when to stop, what is reported."""
