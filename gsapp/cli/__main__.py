"""Run the command line as ``python -m gsapp.cli``."""

from gsapp.cli.main import run_program

if __name__ == "__main__":
    run_program()
