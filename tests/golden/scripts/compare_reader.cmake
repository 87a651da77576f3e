# cmake -DPYTHON=... -DREADER=... -DFILE=X.ldp -P compare_reader.cmake: the reader's checksums against X.txt
execute_process(COMMAND ${PYTHON} ${READER} ${FILE} OUTPUT_VARIABLE printed RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "the reader failed on ${FILE}")
endif()
string(FIND "${printed}" "layer 1 disparity" start)  # behind the header
string(SUBSTRING "${printed}" ${start} -1 printed)
string(REGEX REPLACE "\\.ldp$" ".txt" expected_file "${FILE}")
file(READ ${expected_file} expected)
if(NOT printed STREQUAL expected)
  message(FATAL_ERROR "expected\n${expected}found\n${printed}")
endif()
