"""Processes that do the numerical work, and the function that fits inside one."""
