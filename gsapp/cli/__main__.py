"""Run the command line as ``python -m gsapp.cli``."""

from gsapp.cli.main import main

if __name__ == "__main__":
    main()
