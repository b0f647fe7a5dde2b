#!/bin/sh
# make-locale.sh <folder>: creates the locale de_DE.UTF-8 (decimal comma) there for the tests, without changing the system;
# programs find it through LOCPATH. Exits with 3 if it is unavailable.
set -eu
[ ! -e "$1/de_DE.UTF-8/LC_NUMERIC" ] || exit 0
command -v localedef >/dev/null || {
  echo "There is no localedef to make a locale with a decimal comma (Debian: packages libc-bin and locales)." >&2
  exit 3
}
mkdir -p "$1"
localedef -i de_DE -f UTF-8 "$1/de_DE.UTF-8" >&2 || {
  rm -rf "$1/de_DE.UTF-8"
  echo "The locale de_DE.UTF-8 could not be made (Debian: package locales has its source)." >&2
  exit 3
}
