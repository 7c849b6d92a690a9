# Writes a ctest file with one test per suite of a GoogleTest program. The program links the network library
# and takes half a second to start, so one process per test would double the time of all tests.
# Variables: PROGRAM (path), OUTPUT (file to write), TIMEOUT_S (of one suite).
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listing RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${status}")
endif()
# All tests of the suite were skipped and none failed: the summary ends with the skipped tests.
set(all_skipped [=[PASSED  \\] 0 tests\\.\n\\[  SKIPPED \\] [0-9]+ tests?, listed below:\n(\\[  SKIPPED \\] [^\n]*\n?)+$]=])
string(REPLACE "\n" ";" lines "${listing}")
set(suites "")
foreach(line IN LISTS lines)
  if(line MATCHES "^([A-Za-z0-9_/]+)\\.")
    list(APPEND suites ${CMAKE_MATCH_1})
  endif()
endforeach()
list(LENGTH suites count)
if(count EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} lists no tests")
endif()
set(text "")
foreach(suite IN LISTS suites)
  string(APPEND text
    "add_test(\"${suite}\" \"${PROGRAM}\" \"--gtest_filter=${suite}.*\")\n"
    "set_tests_properties(\"${suite}\" PROPERTIES TIMEOUT ${TIMEOUT_S}\n"
    "  SKIP_REGULAR_EXPRESSION \"${all_skipped}\")\n")
endforeach()
file(WRITE ${OUTPUT} "${text}")
