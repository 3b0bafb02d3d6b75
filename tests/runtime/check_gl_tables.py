"""check_gl_tables.py ROOT: generates every OpenGL table again and compares it with the one in the tree. 77: the registry is not installed."""
import pathlib
import subprocess
import sys

root = pathlib.Path(sys.argv[1])
bad = 0

names = subprocess.run([sys.executable, root / 'tools/gen_gl_header.py', '--names', '1.2'], capture_output=True, text=True)
if names.returncode == 0 and names.stdout != (root / 'tests/runtime/gl12_names.txt').read_text(encoding='utf-8'):
    print('gl12_names.txt is out of date; run tools/gen_gl_header.py --names 1.2 > tests/runtime/gl12_names.txt')
    bad = 1
for table in ('runtime/gl12_table', 'runtime/glsl_table', 'tools/vtrender/gl_table'):
    run = subprocess.run([sys.executable, root / 'tools/gen_gl_header.py', f'{table}.txt'], cwd=root, capture_output=True, text=True)
    if run.returncode != 0 and 'gl.xml not found' in run.stderr:
        print(run.stderr, end='')
        sys.exit(77)
    if run.returncode != 0 or run.stdout != (root / f'{table}.h').read_text(encoding='utf-8'):
        print(f'{table}.h is not what {table}.txt gives; run tools/gen_gl_header.py {table}.txt > {table}.h\n{run.stderr}')
        bad = 1
sys.exit(bad)
