"""`ekfslam completion`: the Tab key completes commands, options and the names of scenarios."""

from argcomplete.shell_integration import shellcode


def main(options):
    """Run the command."""
    print(shellcode(["ekfslam"], shell=options.shell))
    return 0
