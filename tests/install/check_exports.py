#!/usr/bin/env python3
"""check_exports.py store|runtime HEADERS LIBRARY: a shared library shows what its installed headers declare, and nothing else.

Headers are laid out by clang-format: what stands at the left margin belongs to a namespace, what is indented by two to a class.
"""

import pathlib
import re
import subprocess
import sys

# What one library of ours needs of the other, behind the faces.
BETWEEN_US = {"decode_blocks", "decode_texels"}

FUNCTION = re.compile(r"[^=(]*?(operator\W+|~?\w+)\(")
ELSEWHERE = re.compile(r"\b(using|friend|inline|constexpr|template)\b|#|\{|= (0|default|delete);")


def statements(text: str):
    """(class or "", statement) of all that stands in a namespace or a class, a nested class's members apart."""
    owner, statement, body_end = "", "", None
    for line in re.sub(r" *//.*", "", text).splitlines():
        indent = len(line) - len(line.lstrip())
        if body_end is not None:  # what is inside a function is no declaration
            body_end = None if line.startswith(body_end) else body_end
            continue
        if indent == 0 and (head := re.match(r"(?:class|struct) (\w+).*\{$", line)):
            owner, statement = head.group(1), ""
        elif line == "};":
            owner, statement = "", ""
        elif indent == (2 if owner else 0):
            statement = line.strip()
        else:
            statement += " " + line.strip()
        if statement.endswith((";", "{", "}")):
            yield owner, statement
            if statement.endswith("{") and "(" in statement:
                body_end = "  }" if owner else "}"
            statement = ""


def declarations(text: str) -> set[str]:
    """Functions that a header declares and does not define: "read_region", "StoreReader::open"."""
    found = set()
    for owner, statement in statements(text):
        statement = statement.replace(" = {}", "")
        while "<" in statement and (plain := re.sub(r"<[^<>]*>", "", statement)) != statement:
            statement = plain
        function = FUNCTION.match(statement)
        if function and statement.endswith(";") and not ELSEWHERE.search(statement):
            found.add(f"{owner}::{function.group(1)}".removeprefix("::"))
    return found


def exported(library: str) -> set[str]:
    lines = subprocess.run(["nm", "-DC", "--defined-only", library], check=True, capture_output=True, text=True).stdout.splitlines()
    symbols = set()
    for line in lines:
        _, kind, symbol = line.split(" ", 2)
        if kind != "A":  # the name of the version
            symbols.add(re.sub(r"\[abi:\w+\]|@@.*", "", symbol))
    return symbols


def main() -> int:
    part, headers, library = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    declared = set().union(*(declarations(header.read_text()) for header in sorted((headers / part).rglob("*.h"))))
    symbols = exported(library)
    # "vt::store::StoreReader::open(...)" -> "StoreReader::open"; tables of virtual functions count for their
    # class.
    functions = {re.sub(r"^(vt::)?((store|runtime)::)?", "", symbol.split("(")[0]) for symbol in symbols if "(" in symbol}
    faults = [f"{name} is declared in an installed header and not exported" for name in sorted(declared - functions)]
    faults += [f"{name} is exported and in no installed header" for name in sorted(functions - declared - BETWEEN_US)]
    faults += [f"{symbol} is exported" for symbol in sorted(symbols) if "vt::" not in symbol]
    print("\n".join(faults))
    print(f"{len(declared)} functions declared, {len(symbols)} symbols exported")
    return 1 if faults or not declared else 0


if __name__ == "__main__":
    sys.exit(main())
