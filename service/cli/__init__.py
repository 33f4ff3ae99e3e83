"""The `ipfit` command."""


def main() -> None:
    """Run the command line.

    A worker process imports this module, too, because multiprocessing has every child import its parent's main module.
    The commands, and with them the whole web framework, are therefore imported here and not above: a worker starts in
    tens of milliseconds instead of seconds, and is smaller.
    """
    from service.cli.app import app  # noqa: PLC0415 - see above

    app()
