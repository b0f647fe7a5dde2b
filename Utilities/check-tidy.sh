#!/bin/sh
# Runs clang-tidy (.clang-tidy) on the sources changed since a commit, including the working tree and the sources of changed
# headers, if the default build compiles them. Fails if it finds something.
# Usage: check-tidy.sh [COMMIT]   Default: the last commit older than a day before HEAD; "all": every source. Checks at most
# 60 files, except with "all".
set -eu
cd "$(dirname "$0")/.."
since=${1:-}
nothing() { echo "$1: nothing was checked by clang-tidy." >&2; exit 0; }
command -v clang-tidy >/dev/null || nothing "clang-tidy is not installed"
[ -e build/compile_commands.json ] || nothing "There is no default build"
[ -n "$since" ] || since=$(git rev-list -1 --before="$(($(git show -s --format=%ct HEAD) - 86400))" HEAD)
if [ "$since" = all ]; then
  files=$(git ls-files '*.cxx')
else
  git rev-parse --verify --quiet "$since^{commit}" >/dev/null || nothing "There is no commit $since"
  files=$(git diff --name-only --diff-filter=d "$since" -- '*.cxx' '*.h' | sed 's/\.h$/.cxx/' | sort -u)
fi
# build/compile_commands.json, with the sources that a unity build joins in place of the joined files.
mkdir -p build/tidy
python3 - <<'END'
import json, re
commands = []
for entry in json.load(open('build/compile_commands.json')):
    joined = '/Unity/unity_' in entry['file']
    for file in re.findall(r'#include "(.*)"', open(entry['file']).read()) if joined else [entry['file']]:
        commands.append(entry | {'file': file, 'command': entry['command'].replace(entry['file'], file)})
json.dump(commands, open('build/tidy/compile_commands.json', 'w'), indent=0)
END
compiled=$(for file in $files; do
  if grep -q "\"file\": \"$PWD/$file\"" build/tidy/compile_commands.json; then echo "$file"; fi
done)
count=$(echo "$compiled" | grep -c . || true)
[ "$count" -gt 0 ] || nothing "No source changed"
if [ "$since" != all ] && [ "$count" -gt 60 ]; then
  echo "$count files changed: clang-tidy checks 60 of them; '$0 all' checks every one." >&2
  compiled=$(echo "$compiled" | awk -v n="$count" 'int(NR * 60 / n) > int((NR - 1) * 60 / n)')
fi
said=$(echo "$compiled" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/tidy --quiet 2>/dev/null || true)
# E.g. because of the headers of Debian's ITK 5.2.
failed=$(echo "$said" | sed -n 's/: error: .*\[clang-diagnostic-error\]$//p' | sort -u)
[ -z "$failed" ] || printf 'clang cannot compile these, so what uses them was checked in part:\n%s\n' "$failed" >&2
found=$(echo "$said" | grep -A 3 -E '\[(bugprone|performance)-[a-z,-]*\]$' || true)
[ -z "$found" ] || { echo "$found"; exit 1; }
