"""Checks that an OpenGL trace holds no function and no constant newer than a version.

    check_gl12.py TRACE [--allow GL_EXT_NAME ...] [--max 1.2] [--list]
    check_gl12.py --run PROGRAM [ARGUMENT ...]        traces PROGRAM by apitrace (EGL) first

Exit code 0: clean. 1: something newer, or nothing traced at all. 77: apitrace or the registry is not installed.
"""
import argparse
import collections
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET


def find_registry():
    try:
        listing = subprocess.check_output(['dpkg', '-L', 'khronos-api'], text=True, stderr=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError):
        return None
    return next((line for line in listing.split() if line.endswith('/gl.xml')), None)


def version_of(text):
    return tuple(int(part) for part in text.split('.'))


def check(trace, newest, allow, show_list):
    registry = find_registry()
    if registry is None:
        print('gl.xml not found: install khronos-api')
        return 77
    root = ET.parse(registry).getroot()
    value = {e.get('name'): int(e.get('value'), 0) for e in root.iterfind('enums/enum')}
    functions, enums, origin = set(), set(), {}

    def take(part, label, allowed):
        here = {kind: {item.get('name') for item in part.iterfind(kind)} for kind in ('command', 'enum')}
        for name in here['command'] | here['enum']:
            origin.setdefault(name, label)
        if allowed:
            functions.update(here['command'])
            enums.update(here['enum'])

    for feature in root.iterfind('feature'):
        if feature.get('api') == 'gl':
            for part in feature.iterfind('require'):
                take(part, 'GL ' + feature.get('number'), version_of(feature.get('number')) <= version_of(newest))
    for extension in root.iterfind('extensions/extension'):
        for part in extension.iterfind('require'):
            take(part, extension.get('name'), extension.get('name') in allow)
    # apitrace prints one of several names of a number; an allowed number is allowed by any name.
    allowed_values = {value[name] for name in enums if name in value}

    dump = subprocess.run(['apitrace', 'dump', '--color=never', '--call-nos=no', '--arg-names=no', trace], check=True, capture_output=True,
                          text=True, errors='replace').stdout
    calls, newer_enums = collections.Counter(), collections.Counter()
    for line in dump.splitlines():  # calls marked '// fake' count too: client arrays are recorded only so
        match = re.match(r'(gl[A-Z]\w*)\(', line)
        if not match or line.startswith('glX'):
            continue
        calls[match.group(1)] += 1
        for name in set(re.findall(r'\bGL_[A-Za-z0-9_]+', re.sub(r'"(\\.|[^"\\])*"', '""', line))):
            if name not in enums and value.get(name, -1) not in allowed_values:
                newer_enums[(match.group(1), name)] += 1
    newer = {name: count for name, count in calls.items() if name not in functions}

    if show_list:
        for name in sorted(calls):
            print(f'{calls[name]:8d} {name:32s} {origin.get(name, "?")}')
    for name in sorted(newer):
        print(f'newer than OpenGL {newest}: {name} ({origin.get(name, "?")}), {newer[name]} times')
    for (function, name), count in sorted(newer_enums.items()):
        print(f'newer than OpenGL {newest}: {name} ({origin.get(name, "?")}) in {function}, {count} times')
    print(f'{sum(calls.values())} calls of {len(calls)} functions; {len(newer)} functions and {len(newer_enums)} uses of constants are newer than {newest}')
    return 1 if newer or newer_enums or not calls else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('trace', nargs='?')
    parser.add_argument('--allow', action='append', default=[], metavar='GL_EXT_NAME')
    parser.add_argument('--max', default='1.2')
    parser.add_argument('--list', action='store_true')
    parser.add_argument('--run', nargs=argparse.REMAINDER)
    args = parser.parse_args()
    if shutil.which('apitrace') is None:
        print('apitrace is not installed')
        sys.exit(77)
    if not args.run:
        sys.exit(check(args.trace, args.max, args.allow, args.list))
    with tempfile.TemporaryDirectory() as folder:
        trace = os.path.join(folder, 'run.trace')
        ran = subprocess.run(['apitrace', 'trace', '--api=egl', '-o', trace] + args.run, capture_output=True, text=True)
        if ran.returncode != 0 or not os.path.exists(trace):
            print(ran.stdout[-3000:], ran.stderr[-3000:], 'the traced program failed', sep='\n')
            sys.exit(1)
        sys.exit(check(trace, args.max, args.allow, args.list))


main()
