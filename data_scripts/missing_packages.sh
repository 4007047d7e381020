#!/bin/sh
# Print, on one line, the packages of some lists that this Debian system lacks; nothing on other systems.
command -v dpkg-query >/dev/null && command -v apt-get >/dev/null || exit 0
for package in $(sed 's/#.*//' "$@"); do
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || printf '%s ' "$package"
done
