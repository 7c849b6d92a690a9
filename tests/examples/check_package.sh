#!/usr/bin/env bash
# Installs pickbed to a temporary folder. Compiles the installed headers with nothing but Eigen, and builds the
# examples as a project of its own with find_package(pickbed).
#
#   check_package.sh SOURCE_FOLDER BUILD_FOLDER COMPILER
set -eu
source=$1 build=$2 compiler=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
fail() { echo "$*" >&2; exit 1; }
# Prints the output of a command only if it fails.
quietly() { "$@" >"$work/log" 2>&1 || { tail -30 "$work/log"; fail "failed: $*"; }; }

quietly cmake --install "$build" --prefix "$prefix"

targets=$(find "$prefix" -name 'pickbedTargets*.cmake')
# shellcheck disable=SC2086
leaked=$(grep -nE -- "-W|-fno|sanitize|$source" $targets) && fail "the package has our own flags or folders: $leaked"

cd "$prefix/include/pickbed"
find . -name '*.h' -printf '#include "%P"\n' | LC_ALL=C sort >"$work/headers.cpp"
[ "$(wc -l <"$work/headers.cpp")" -gt 150 ] || fail "only few headers are installed"
eigen=$(pkg-config --cflags eigen3)
# shellcheck disable=SC2086
quietly "$compiler" -std=c++20 -Wall -Wextra -Werror -fsyntax-only -I. ${eigen/-I/-isystem } "$work/headers.cpp"

mkdir "$work/project"
cp "$source"/tests/examples/CMakeLists.txt "$source"/tests/examples/*.cpp "$work/project"
quietly cmake -S "$work/project" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler"
quietly cmake --build "$work/build"
for example in render_bin own_estimator; do
  PICKBED_ASSETS=$prefix/share/pickbed/assets "$source/tests/examples/check.sh" $example "$work/build/$example"
done

# The installed program puts the installed Python package on the path of plug-ins.
printf 'import pickbed_plugin as pb\nimport sys\nsys.exit(pb.__file__)\n' >"$work/plugin.py"
"$prefix/bin/pickbed" plugin check "/usr/bin/python3 $work/plugin.py" --set objects.0.count=1 >"$work/log" 2>&1 || true
grep -qF "$prefix/share/pickbed/python/pickbed_plugin.py" "$work/log" || { cat "$work/log"; fail "the Python package is not installed"; }

# The installed Python module uses the installed assets.
module=$(find "$prefix/lib" -name 'pickbed.*.so')
if [ -n "$module" ]; then
  PYTHONPATH=$(dirname "$module") /usr/bin/python3 -c '
import os, pickbed
pickbed.Scenario("clutter")
print(os.environ["PICKBED_ASSETS"])' >"$work/log" 2>&1 || { cat "$work/log"; fail "the Python module is not installed"; }
  grep -qx "$prefix/share/pickbed/assets" "$work/log" || { cat "$work/log"; fail "the Python module uses other assets"; }
fi

# A program in the folder of the installed one uses the installed assets.
cp "$work/build/render_bin" "$prefix/bin"
rm -r "$prefix/share/pickbed/assets/objects/pipe_tee"
if "$prefix/bin/render_bin" "$work" >"$work/log" 2>&1 || ! grep -q "pipe_tee" "$work/log"; then
  fail "the assets beside the program were not used"
fi
