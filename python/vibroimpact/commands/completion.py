"""`vibroimpact completion`: a script that lets the shell complete commands, options and their values."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import NamedTuple

HELP = "print a script for the shell, which then completes what is typed"
DESCRIPTION = """Print a script by which bash, zsh or fish completes commands, options, their values and files:

  bash   mkdir -p ~/.local/share/bash-completion/completions
         vibroimpact completion bash > ~/.local/share/bash-completion/completions/vibroimpact
  zsh    put into ~/.zshrc, after compinit: source <(vibroimpact completion zsh)
  fish   mkdir -p ~/.config/fish/completions
         vibroimpact completion fish > ~/.config/fish/completions/vibroimpact.fish"""
EXAMPLE = "vibroimpact completion bash"

SHELLS = ("bash", "zsh", "fish")


class Option(NamedTuple):
    """An option as it is typed, with what it is, the values that it takes, and whether it takes one."""

    flags: list[str]
    help: str
    choices: list[str]
    takes: bool


class Command(NamedTuple):
    """A command with its options, and what it takes beside them (files, if that is empty)."""

    help: str
    options: list[Option]
    words: list[str]


def arguments(parser: argparse.ArgumentParser) -> None:
    """The shell."""
    parser.add_argument("shell", choices=SHELLS, help=" or ".join(SHELLS))


def run(options: argparse.Namespace) -> int:
    """Print it."""
    writer = {"bash": bash, "zsh": zsh, "fish": fish}[options.shell]
    print(writer(commands()), end="")
    return 0


def commands() -> Mapping[str, Command]:
    """All commands, as the parsers know them."""
    from ..command import parsers
    from ..reproduce import NAMES

    found = {}
    for name, parser in parsers()[1].items():
        options, words = [], list(NAMES) if name == "reproduce" else []
        for action in parser._actions:
            choices = [str(item) for item in action.choices or ()]
            if action.option_strings:
                takes = action.nargs != 0
                options.append(
                    Option(list(action.option_strings), action.help or "", choices, takes)
                )
            else:
                words += choices
        found[name] = Command((parser.description or "").partition(".")[0], options, words)
    return found


def bash(known: Mapping[str, Command]) -> str:
    """A function for bash."""
    values, flags, words = [], [], []
    for name, command in known.items():
        for option in command.options:
            if option.choices:
                pattern = "|".join(f'"{name} {flag}"' for flag in option.flags)
                values.append(f"    {pattern}) words='{' '.join(option.choices)}' ;;")
        all_flags = " ".join(flag for option in command.options for flag in option.flags)
        flags.append(f"    {name}) words='{all_flags}' ;;")
        if command.words:
            words.append(f"    {name}) words='{' '.join(command.words)}' ;;")
    newline = "\n"
    return f"""# completes what is typed after vibroimpact
_vibroimpact() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command=${{COMP_WORDS[1]}}
  local words=
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{" ".join(known)} --help --version' -- "$current"))
    return
  fi
  case "$command $before" in
{newline.join(values)}
  esac
  if [ -z "$words" ]; then
    case "$current" in
      -*) case "$command" in
{newline.join(flags)}
      esac ;;
      *) case "$command" in
{newline.join(words)}
      esac ;;
    esac
  fi
  if [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  else
    local IFS=$'\\n'  # names may hold blanks
    COMPREPLY=($(compgen -f -- "$current"))
  fi
}}
complete -o filenames -F _vibroimpact vibroimpact
"""


def zsh(known: Mapping[str, Command]) -> str:
    """The same function, by way of zsh's own layer for those of bash."""
    return f"autoload -U +X bashcompinit && bashcompinit\n{bash(known)}"


def fish(known: Mapping[str, Command]) -> str:
    """One line a command, option or word."""
    lines = ["# completes what is typed after vibroimpact"]
    for name, command in known.items():
        first = "complete -c vibroimpact -n __fish_use_subcommand -f"
        lines.append(f"{first} -a {name} -d {quoted(command.help)}")
        here = f"complete -c vibroimpact -n '__fish_seen_subcommand_from {name}'"
        for option in command.options:
            flags = " ".join(
                f"-l {flag[2:]}" if flag.startswith("--") else f"-s {flag[1:]}"
                for flag in option.flags
            )
            takes = (
                f" -x -a {quoted(' '.join(option.choices))}"
                if option.choices
                else " -r" * option.takes
            )
            lines.append(f"{here} {flags}{takes} -d {quoted(option.help)}")
        if command.words:
            lines.append(f"{here} -f -a {quoted(' '.join(command.words))}")
    return "\n".join(lines) + "\n"


def quoted(text: str) -> str:
    """A text for fish, on one line."""
    plain = " ".join(text.replace("%%", "%").split())
    return "'" + plain.replace("\\", "\\\\").replace("'", "\\'") + "'"
