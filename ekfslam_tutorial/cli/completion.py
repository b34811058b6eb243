"""`ekfslam completion`: the Tab key completes commands, options and the names of scenarios."""

import argcomplete


def main(options):
    """Run the command."""
    print(argcomplete.shellcode(["ekfslam"], shell=options.shell))
    return 0
