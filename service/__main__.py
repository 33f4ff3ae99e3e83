"""`python -m service` is `ipfit`."""

from service.cli import main

main()
