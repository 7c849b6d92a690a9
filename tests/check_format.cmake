# Fails if clang-format would change a source file.
file(GLOB_RECURSE files ${ROOT}/scenes/*.h ${ROOT}/scenes/*.cpp ${ROOT}/sim/*.h ${ROOT}/sim/*.cpp
  ${ROOT}/perception/*.h ${ROOT}/perception/*.cpp ${ROOT}/grasp/*.h ${ROOT}/grasp/*.cpp
  ${ROOT}/eval/*.h ${ROOT}/eval/*.cpp ${ROOT}/tests/*.h ${ROOT}/tests/*.cpp)
execute_process(COMMAND ${CLANG_FORMAT} --dry-run --Werror ${files}
  RESULT_VARIABLE status ERROR_VARIABLE messages WORKING_DIRECTORY ${ROOT})
if(NOT status EQUAL 0)
  message(FATAL_ERROR "run: make format\n${messages}")
endif()
