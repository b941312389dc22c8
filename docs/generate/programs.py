"""The help text of the programs."""

import os
import subprocess

from vibroimpact.command import parsers

from .shared import PROGRAM


def pages():
    """`vibroimpact`, each of its commands, and `vibroimpact-batch`."""
    os.environ["COLUMNS"] = "80"
    main, each = parsers()
    batch = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
    texts = {
        "vibroimpact-batch": batch,
        "vibroimpact": main.format_help(),
        **{f"vibroimpact {name}": parser.format_help() for name, parser in each.items()},
    }
    lines = [f"## {name}\n\n```text\n{text.rstrip()}\n```\n" for name, text in texts.items()]
    return {"programs.md": "\n".join(lines)}
