# Fails if a generated page of the reference is not up to date.
#
#   cmake -DPROGRAM=pickbed_make_reference -DPAGES=docs/pages/reference -DWORK=FOLDER -P check_reference.cmake
#
# WORK is replaced.
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK})
execute_process(COMMAND ${PROGRAM} ${WORK} COMMAND_ERROR_IS_FATAL ANY)
set(mark "Written by pickbed_make_reference")
set(differing "")
file(GLOB made RELATIVE ${WORK} ${WORK}/*.md)
foreach(page ${made})
  if(NOT EXISTS ${PAGES}/${page})
    list(APPEND differing ${page})
    continue()
  endif()
  file(SHA256 ${WORK}/${page} now)
  file(SHA256 ${PAGES}/${page} committed)
  if(NOT now STREQUAL committed)
    list(APPEND differing ${page})
  endif()
endforeach()
# Pages of an earlier version.
file(GLOB present RELATIVE ${PAGES} ${PAGES}/*.md)
foreach(page ${present})
  file(STRINGS ${PAGES}/${page} generated REGEX "${mark}")
  if(generated AND NOT page IN_LIST made)
    list(APPEND differing ${page})
  endif()
endforeach()
if(NOT made)
  list(APPEND differing "no page was written")
endif()
if(differing)
  list(JOIN differing ", " names)
  message(NOTICE "${names}: not up to date; run ${PROGRAM} ${PAGES}")
  message(FATAL_ERROR "The generated reference is not up to date.")
endif()
