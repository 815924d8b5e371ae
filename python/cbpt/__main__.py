"""`python -m cbpt`: the command, where no script of the environment is on the path."""

from cbpt.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
