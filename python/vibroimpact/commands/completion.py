"""`vibroimpact completion`: a script that lets the shell complete commands, options and their values."""

from __future__ import annotations

import argparse

from ..base.errors import MissingExtraError

DESCRIPTION = """Print a script that lets a shell complete commands, options, their values and files. It needs
the extra `completion`: pip install 'vibroimpact[completion]'.

  bash   mkdir -p ~/.local/share/bash-completion/completions
         vibroimpact completion bash > ~/.local/share/bash-completion/completions/vibroimpact
  zsh    put into ~/.zshrc, after compinit: eval "$(vibroimpact completion zsh)"
  fish   mkdir -p ~/.config/fish/completions
         vibroimpact completion fish > ~/.config/fish/completions/vibroimpact.fish"""
EXAMPLE = "vibroimpact completion bash"

SHELLS = ("bash", "zsh", "fish")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The shell."""
    parser.add_argument("shell", choices=SHELLS, help=" or ".join(SHELLS))


def run(options: argparse.Namespace) -> int:
    """Print it."""
    try:
        import shtab
    except ImportError:
        raise MissingExtraError(
            "completion in a shell needs shtab: pip install 'vibroimpact[completion]'"
        ) from None
    from ..reproduce import NAMES
    from .command import parsers

    parser, each = parsers()
    for name, command in each.items():
        for action in command.added:
            if name == "reproduce" and action.dest == "names":
                action.choices = list(NAMES)
            elif action.dest in ("files", "folder", "file"):
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(parser, options.shell))
    return 0
