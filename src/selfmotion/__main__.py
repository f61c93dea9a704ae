"""`python -m selfmotion` is the command line."""

import sys

from selfmotion.cli.app import main

if __name__ == "__main__":
    sys.exit(main())
