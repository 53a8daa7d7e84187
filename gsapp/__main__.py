"""Run the command line as ``python -m gsapp``."""

from gsapp.cli import run_program

if __name__ == "__main__":
    run_program()
