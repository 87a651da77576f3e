#!/bin/sh
# What ctest runs last: names each test that was skipped, or a part of it, with the reason that it printed.
#   tell_skips.sh TESTING_FOLDER       that of ctest's log
# A reason is what follows "skipped: " at the beginning of a line or after the program's name, GoogleTest's, or unittest's.
log=$1/LastTest.log
[ ! -e "$log.tmp" ] || log=$log.tmp  # it has its name when ctest has ended
[ -e "$log" ] || exit 0
awk '
  function tell(reason) { if (!told[name reason]++) print "skipped: " name ": " reason }
  / Test: / && sub(/^[0-9]+\/[0-9]+ Test: /, "") { name = $0; next }
  /^Output:$/ { printed = 1; next }
  /^<end of output>/ { printed = 0 }
  !printed { next }
  google && /[^ ]/ { tell($0); google = 0; next }
  /: Skipped$/ { google = 1; next }
  /^([A-Za-z0-9_.-]+: )?skipped: ./ { sub(/^([A-Za-z0-9_.-]+: )?skipped: /, ""); tell($0); next }
  / \.\.\. skipped / { sub(/^.* \.\.\. skipped /, ""); gsub(/^["\047]|["\047]$/, ""); tell($0) }
' "$log"
exit 0
