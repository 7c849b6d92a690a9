# Writes a ctest file with the suites of a GoogleTest program. A ctest entry runs up to eight suites in one process
# and is named after them, because a program with the network library takes .4 s to start. Suites
# that take long are entries of their own, which start first.
# Variables: PROGRAM (path), OUTPUT (file to write), TIMEOUT_S (of one entry).
cmake_minimum_required(VERSION 3.25)
set(slow Trial VerifiedPpf ReplayTest Methods/PublishedMethod WohlhartInBins EstimateRooms All/FuzzTargetTest
  EstimateDatasetTest OcclusionSeriesTest Descriptor UnionOfVotes Training BracketsOnATable PoseFreeTrial
  OcclusionTrial SuccessTraining CellErrors ImagePickTrial AddedObject GraspExamples)
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listing RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${status}")
endif()
# All tests of the entry were skipped and none failed: the summary ends with the skipped tests.
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
# add_entry(suites...): adds a ctest entry.
function(add_entry)
  list(JOIN ARGN ", " name)
  list(JOIN ARGN ".*:" filter)
  set(cost "")
  if(ARGN IN_LIST slow)
    set(cost "COST 100")
  endif()
  string(APPEND text
    "add_test(\"${name}\" \"${PROGRAM}\" \"--gtest_filter=${filter}.*\")\n"
    "set_tests_properties(\"${name}\" PROPERTIES TIMEOUT ${TIMEOUT_S} ${cost}\n"
    "  SKIP_REGULAR_EXPRESSION \"${all_skipped}\")\n")
  set(text "${text}" PARENT_SCOPE)
endfunction()
set(group "")
foreach(suite IN LISTS suites)
  if(suite IN_LIST slow)
    add_entry(${suite})
    continue()
  endif()
  list(APPEND group ${suite})
  list(LENGTH group count)
  if(count EQUAL 8)
    add_entry(${group})
    set(group "")
  endif()
endforeach()
if(group)
  add_entry(${group})
endif()
file(WRITE ${OUTPUT} "${text}")
