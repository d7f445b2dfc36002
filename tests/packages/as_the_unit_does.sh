#!/bin/sh
# Starts the service in a root that has no systemd: by the installed unit's user, variables and
# command line. Its other settings (limits, what it may see and write) are systemd's alone.
set -eu
unit=/usr/lib/systemd/system/geodesicd.service
setting() { sed -n "s/^$1=-\{0,1\}//p" "$unit"; }
user=$(setting User)
set -a
eval "$(setting Environment | tr ' ' '\n')"
# shellcheck source=/dev/null
. "$(setting EnvironmentFile)"
set +a
# shellcheck disable=SC2046  # words
exec setpriv --reuid="$user" --regid="$user" --init-groups --no-new-privs --bounding-set=-all \
  $(setting ExecStart)
