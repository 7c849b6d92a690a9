// A test file that no CMakeLists.txt names.
