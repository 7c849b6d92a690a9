# Fails when an #include runs against the plan of the house: a folder may see only the folders below
# it, and a third-party header only stands in its room.
#
#   cmake -DROOT=. -P check_includes.cmake
cmake_minimum_required(VERSION 3.25)

set(may_include_scenes scenes)
set(may_include_sim sim scenes)
set(may_include_perception perception scenes)
set(may_include_grasp grasp sim scenes)
set(may_include_eval eval grasp perception sim scenes)
set(folders scenes sim perception grasp eval)

# Third-party header prefix -> pattern of the files that may include it. Headers in public .h files
# are allowed for Eigen alone; a private header of a room is named here.
set(rooms
  "btBullet|BulletCollision|BulletDynamics|LinearMath=>^sim/[a-z_]+(\\.cpp|_impl\\.h)$"
  "GL/|EGL/|KHR/=>^sim/(gl_[a-z_]+\\.(cpp|h)|renderer[a-z_]*\\.cpp|visibility\\.cpp)$"
  "torch/|ATen/|c10/=>^(tests/)?perception/(torch_[a-z_]+\\.(cpp|h)|networks/[a-z_]+\\.(cpp|h))$"
  "pcl/=>^perception/(icp|normals)\\.cpp$"
  "flann/=>^perception/neighbors\\.cpp$"
  "assimp/=>^scenes/(mesh_io|glb_writer)\\.cpp$"
  "opencv2/=>^(scenes/image_io\\.cpp|eval/report/draw[a-z_]*\\.cpp|perception/estimators/ppf_matcher\\.cpp|perception/(hog|linemod)\\.cpp)$"
  "yaml-cpp/=>^scenes/settings(_tree)?\\.cpp$"
  "sqlite3=>^eval/results_[a-z_]+(\\.cpp|_impl\\.h)$"
  "boost/=>^eval/(statistics|paired_tests)\\.cpp$"
  "nlohmann/=>^eval/.+(\\.cpp|_impl\\.h)$"
  "CLI/|spdlog/=>^eval/.+\\.(cpp|h)$"
)

set(problems "")
foreach(folder ${folders})
  file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/${folder}/*.h ${ROOT}/${folder}/*.cpp)
  foreach(file ${files})
    file(STRINGS ${ROOT}/${file} lines REGEX "^#include")
    foreach(line ${lines})
      if(NOT line MATCHES "^#include [<\"]([^>\"]+)[>\"]")
        continue()
      endif()
      set(header ${CMAKE_MATCH_1})
      foreach(target ${folders})
        if(header MATCHES "^${target}/" AND NOT target IN_LIST may_include_${folder})
          string(APPEND problems "${file} includes ${header}: ${folder} may not see ${target}\n")
        endif()
      endforeach()
      # The truth is kept from whoever has to guess it.
      if(folder STREQUAL perception AND header MATCHES "^scenes/scene\\.h$")
        string(APPEND problems "${file} includes ${header}: perception may not see the truth\n")
      endif()
      foreach(room ${rooms})
        string(REGEX MATCH "^(.*)=>(.*)$" unused "${room}")
        set(prefix "${CMAKE_MATCH_1}")
        set(allowed "${CMAKE_MATCH_2}")
        if(header MATCHES "^(${prefix})" AND NOT file MATCHES "${allowed}")
          string(APPEND problems "${file} includes ${header}: allowed in ${allowed} alone\n")
        endif()
      endforeach()
    endforeach()
  endforeach()
endforeach()

if(problems)
  message(FATAL_ERROR "${problems}")
endif()
