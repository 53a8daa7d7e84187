"""Run the command line as ``python -m gsapp``."""

from gsapp.cli import main

if __name__ == "__main__":
    main()
