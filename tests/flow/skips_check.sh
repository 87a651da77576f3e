#!/bin/sh
# ctest names what it skipped and why: a project of three tests, each skipped in a way of its own, and one that is not.
#   skips_check.sh CTEST TELL_SKIPS
set -e
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
cat >CTestTestfile.cmake <<'END'
add_test(program sh -c "echo 'check: skipped: no pip'; exit 77")
set_tests_properties(program PROPERTIES SKIP_RETURN_CODE 77)
add_test(google sh -c "echo 'a.cpp:3: Skipped'; echo 'no ffmpeg'; echo; echo '[  SKIPPED ] A.B (0 ms)'")
set_tests_properties(google PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED")
add_test(part sh -c "echo \"test_plots (A) ... skipped 'no matplotlib'\"; echo OK")
add_test(none sh -c "echo 'nothing was skipped: all is well'")
END
echo "set(CTEST_CUSTOM_POST_TEST \"sh $2 $room/Testing/Temporary\")" >CTestCustom.cmake
"$1" >said
grep '^skipped: ' said >told || true
printf 'skipped: %s\n' 'program: no pip' 'google: no ffmpeg' 'part: no matplotlib' | diff - told
