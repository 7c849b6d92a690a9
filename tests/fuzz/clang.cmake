# Flags of the build with clang and libFuzzer, which compiles only the fuzz targets.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL Clang OR NOT PICKBED_SANITIZE)
  message(FATAL_ERROR "PICKBED_FUZZ needs clang and PICKBED_SANITIZE; use cmake --preset fuzz")
endif()

# The release build with g++ gives the warnings. Copies of a function for several processors are chosen
# before the sanitizers have started, so they are left out.
target_compile_options(pickbed_flags INTERFACE -w "SHELL:-D'target_clones(...)='" -fsanitize=fuzzer-no-link)

# clang refuses libtorch 1.13 in C++20: its headers use a std::vector of an incomplete type, which a
# constexpr function must not. These copies of two headers of libstdc++ have no constexpr functions for
# std::vector, except for std::vector<bool>.
set(copies ${CMAKE_BINARY_DIR}/libstdcxx)
foreach(name stl_vector.h vector.tcc)
  file(READ /usr/include/c++/12/bits/${name} all)
  string(FIND "${all}" "  // vector<bool>\n" split)
  string(SUBSTRING "${all}" 0 ${split} vector)
  string(REPLACE _GLIBCXX20_CONSTEXPR "" vector "${vector}")
  set(rest "")
  if(NOT split EQUAL -1)
    string(SUBSTRING "${all}" ${split} -1 rest)
  endif()
  file(CONFIGURE OUTPUT ${copies}/bits/${name} CONTENT "${vector}${rest}" @ONLY)
endforeach()
target_include_directories(pickbed_flags SYSTEM BEFORE INTERFACE ${copies})
