"""The help text of the programs."""

import os
import subprocess
import textwrap

from vibroimpact.commands.command import parsers

from .shared import PROGRAM

#: Characters in a line.
WIDTH = 96


def wrapped(text):
    """A text whose long examples are wrapped between options."""
    fold = textwrap.TextWrapper(WIDTH, subsequent_indent=4 * " ", break_on_hyphens=False)
    return "\n".join(
        fold.fill(line) if line.startswith("example: ") else line
        for line in text.rstrip().splitlines()
    )


def pages():
    """`vibroimpact`, each of its commands, and `vibroimpact-batch`."""
    os.environ["COLUMNS"] = str(WIDTH)
    main, each = parsers()
    batch = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
    texts = {
        "vibroimpact-batch": batch,
        "vibroimpact": main.format_help(),
        **{f"vibroimpact {name}": parser.format_help() for name, parser in each.items()},
    }
    lines = [f"## {name}\n\n```text\n{wrapped(text)}\n```\n" for name, text in texts.items()]
    return {"programs.md": "\n".join(lines)}
