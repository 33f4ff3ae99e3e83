"""The `ipfit` command."""


def main() -> None:
    """Run the command line.

    Worker processes import this module, too: with multiprocessing every child imports the main module of its parent.
    The commands, and with them the web framework, are therefore imported in this function and not above. So a worker
    starts in tens of milliseconds instead of seconds, and takes less memory.
    """
    from service.cli.app import app  # noqa: PLC0415 - see above

    app()
