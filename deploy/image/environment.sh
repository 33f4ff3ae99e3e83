#!/bin/sh
# Make the environment /opt/venv of an image from the wheels in /wheels, with nothing in it that a service never reads:
#
#     environment.sh REQUIREMENT        # ipfit with extras, such as "ipfit[otel,s3]"
#
# pip takes what the requirement needs and no more; that all wheels are those of the lock was checked when they came.
set -eu

python -m venv --without-pip /opt/venv
/opt/tools/bin/pip --quiet --python /opt/venv/bin/python install --no-index --find-links /wheels --no-compile "$1"
here=$(cd "$(dirname "$0")" && pwd)
cd /opt/venv/lib/python*/site-packages

# Tests, stubs for type checkers, and the sources and headers of what is compiled already.
find . -type d -name tests -prune -exec rm -r {} +
find . -type f \( -name '*.pyi' -o -name '*.pyx' -o -name '*.pxd' -o -name '*.pxi' -o -name '*.c' -o -name '*.h' -o \
    -name '*.hpp' -o -name '*.f' -o -name '*.f90' -o -name '*.pyf' -o -name '*.a' \) -delete

# zstandard brings its library twice; the one for cffi is for other Pythons.
if ls zstandard/backend_c.*.so >/dev/null; then rm -f zstandard/_cffi.*.so zstandard/backend_cffi.py; fi

# Some modules were released with what a debugger reads, up to nine tenths of their size. A package with a .libs beside it
# is left as it is: its files were rewritten after linking, which strip may not know how to handle.
for package in */; do
    [ -d "${package%/}.libs" ] || find "$package" -type f -name '*.so' -exec strip --strip-debug {} +
done

PYTHONPYCACHEPREFIX=/opt/venv/bytecode /opt/venv/bin/python "$here/bytecode.py"
