"""The command line `tribofmu`."""


def main() -> None:
    """Run the command line and leave with its exit code; an interrupt while it starts is one, too."""
    import sys

    try:
        from .main import main as start
    except KeyboardInterrupt:
        print("tribofmu: interrupted; nothing was written", file=sys.stderr)
        sys.exit(130)
    start()


__all__ = ["main"]
