#!/usr/bin/env python3
"""Writes a program's manual page and bash completion from what it prints for --help, so that neither can say anything else.

    help_pages.py --version 0.1.0 PROGRAM MANUAL COMPLETION

Help texts are those of the CLI11 library: sections whose title ends in a colon, and in them entries of two columns, or free lines.
"""

import argparse
import pathlib
import re
import subprocess
from dataclasses import dataclass, field

SECOND_COLUMN = 30  # where the text of an entry begins; a longer first column stands on a line of its own


@dataclass
class Entry:
    head: str  # "-o,--output TEXT REQUIRED", "INPUT TEXT ...", "layer"
    text: str


@dataclass
class Section:
    title: str
    lines: list[str] = field(default_factory=list)  # as printed, without the title

    def is_columns(self) -> bool:
        return self.title.startswith(("Options", "Positionals", "Subcommands"))

    def entries(self) -> list[Entry]:
        entries: list[Entry] = []
        for number, line in enumerate(self.lines):
            following = self.lines[number + 1] if number + 1 < len(self.lines) else ""
            if is_continuation(line):
                entries[-1].text = (entries[-1].text + " " + line.strip()).strip()
            elif is_continuation(following) or len(line) <= SECOND_COLUMN:
                entries.append(Entry(line.strip(), ""))
            else:
                entries.append(Entry(line[:SECOND_COLUMN].strip(), line[SECOND_COLUMN:].strip()))
        return entries


@dataclass
class Help:
    command: list[str]  # ["vtbuild", "layer"]
    description: str = ""
    usage: str = ""
    sections: list[Section] = field(default_factory=list)

    def section(self, title: str) -> Section | None:
        return next((section for section in self.sections if section.title == title), None)

    def entries(self, kind: str) -> list[Entry]:
        return [entry for section in self.sections if section.title.startswith(kind) for entry in section.entries()]


def is_continuation(line: str) -> bool:
    return line.startswith(" " * SECOND_COLUMN)


def read_help(program: str, subcommand: list[str]) -> Help:
    text = subprocess.run([program, *subcommand, "--help"], check=True, capture_output=True, text=True).stdout
    help_text = Help([pathlib.Path(program).name, *subcommand])
    in_group = exactly_one = False  # CLI11 indents a group of options by two more
    for line in text.splitlines():
        if not line.strip():
            in_group = False
        elif line.startswith("[Option Group:"):
            in_group = True
        elif line.startswith("Usage: "):
            help_text.usage = line.removeprefix("Usage: ")
        elif in_group and not line.startswith("    "):
            title = line.strip()
            if title.endswith(":"):
                help_text.sections.append(Section(f"{title[:-1]}, of which exactly one is needed" if exactly_one else title[:-1]))
            elif title.startswith("["):
                exactly_one = "Exactly 1" in title
        elif line[0] != " " and line.endswith(":"):
            help_text.sections.append(Section(line[:-1]))
        elif not help_text.sections:
            help_text.description = (help_text.description + " " + line).strip()
        elif line[0] != " ":
            help_text.sections.append(Section("", [line]))
        else:
            help_text.sections[-1].lines.append(line[2:] if in_group else line)
    if not help_text.usage or not help_text.entries("Options"):
        raise SystemExit(f"{' '.join(help_text.command)} --help reads otherwise than expected")
    return help_text


# --- Manual page ---


def roff(text: str) -> str:
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + escaped if escaped.startswith((".", "'")) else escaped


def sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".") + "."


def manual_of_section(section: Section, heading: str) -> list[str]:
    title = section.title.upper() if heading == ".SH" else section.title
    out = [f'{heading} "{roff(title)}"'] if title else [".PP"]
    if section.is_columns():
        for entry in section.entries():
            out += [".TP", f".B {roff(entry.head)}", *([roff(entry.text)] if entry.text else [])]
    elif section.title == "Examples":
        out += [".nf", *(roff(line[2:]) for line in section.lines), ".fi"]
    else:
        out += [roff(line.strip()) for line in section.lines]
    return out


def manual(main: Help, subcommands: list[Help], version: str) -> str:
    name = main.command[0]
    summary = main.description.split(". ")[0].rstrip(".")
    out = [
        f'.TH {name.upper()} 1 "" "vt {version}" "User Commands"',
        ".SH NAME",
        f"{name} \\- {roff(summary[:1].lower() + summary[1:])}",
        ".SH SYNOPSIS",
    ]
    for help_text in [main, *subcommands]:
        out += [f".B {roff(help_text.usage)}", ".br"]
    out += [".SH DESCRIPTION", roff(main.description)]
    exit_codes = main.section("Exit codes")
    for section in main.sections:
        if section is not exit_codes and section.title:
            out += manual_of_section(section, ".SH")
    for help_text in subcommands:
        out += [f'.SH "{roff(" ".join(help_text.command))}"', roff(sentence(help_text.description))]
        for section in help_text.sections:
            if section.title != "Exit codes":
                out += manual_of_section(section, ".SS")
    if exit_codes:
        out += manual_of_section(Section("Exit status", exit_codes.lines), ".SH")
    return "\n".join(out) + "\n"


# --- Completion ---


def options_of(help_text: Help) -> list[str]:
    return [name for entry in help_text.entries("Options") for name in entry.head.split(" ")[0].split(",")]


def choices_of(entry: Entry) -> list[str]:
    """Values that an option takes, where its help lists them: a|b, {a,b}, or "what it is: a, b or c"."""
    value = entry.head.split(" ")[1] if " " in entry.head else ""
    braces = re.search(r"\{([^}]*)\}", value)
    listed = re.search(r": ((?:[a-z0-9]+, )+[a-z0-9]+(?: or [a-z0-9]+)?)(?: \(|;|$)", entry.text)
    if "|" in value.split(":")[0]:
        words = value.split(":")[0].split("=")[0].split("|")
    elif braces:
        words = braces.group(1).split(",")
    elif listed:
        words = re.split(r", | or ", listed.group(1))
    else:
        words = []
    return [word for word in words if re.fullmatch(r"[a-z0-9][a-z0-9.-]*", word)]


def completion(main: Help, subcommands: list[Help]) -> str:
    name = main.command[0]
    commands = [help_text.command[1] for help_text in subcommands]
    words, values = [], []
    for help_text in [main, *subcommands]:
        command = " ".join(help_text.command[1:])
        words.append(f"    '{command}') options='{' '.join(options_of(help_text))}' ;;")
        for entry in help_text.entries("Options"):
            if choices := choices_of(entry):
                names = "|".join(f"'{command} {option}'" for option in entry.head.split(" ")[0].split(","))
                values.append(f"    {names}) COMPREPLY=($(compgen -W '{' '.join(choices)}' -- \"$current\")); return ;;")
    lines = [
        f"# bash completion of {name}, made from its --help. zsh: `autoload -U bashcompinit && bashcompinit` first.",
        f"_{name}() {{",
        '  local current="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD-1]}" command="" options="" word',
    ]
    if commands:
        lines += [
            '  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do',
            f'    case "$word" in {"|".join(commands)}) command="$word"; break ;; esac',
            "  done",
        ]
    lines += ['  case "$command" in', *words, "  esac"]
    if values:
        lines += ['  case "$command $previous" in', *values, "  esac"]
    lines += [
        "  COMPREPLY=()",
        '  if [[ "$current" == -* ]]; then',
        '    COMPREPLY=($(compgen -W "$options" -- "$current"))',
    ]
    if commands:
        lines += [
            '  elif [[ -z "$command" ]]; then',
            f"    COMPREPLY=($(compgen -W '{' '.join(commands)}' -- \"$current\"))",
        ]
    # Anything else is a file, which readline completes by itself where we have no answer.
    lines += ["  fi", "}", f"complete -o default -F _{name} {name}"]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--version", required=True, dest="program_version")
    parser.add_argument("program")
    parser.add_argument("manual", type=pathlib.Path)
    parser.add_argument("completion", type=pathlib.Path)
    arguments = parser.parse_args()
    main_help = read_help(arguments.program, [])
    subcommands = [read_help(arguments.program, [entry.head]) for entry in main_help.entries("Subcommands")]
    for path, text in [
        (arguments.manual, manual(main_help, subcommands, arguments.program_version)),
        (arguments.completion, completion(main_help, subcommands)),
    ]:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


if __name__ == "__main__":
    main()
