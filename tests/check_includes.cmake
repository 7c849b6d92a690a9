# Fails if an #include violates the architecture. A top-level folder includes only the folders below it.
# A sub-folder includes only sub-folders on lower floors of its folder. A third-party header appears only
# in the files that own the library.
#
#   cmake -DROOT=. -P check_includes.cmake
cmake_minimum_required(VERSION 3.25)

set(folders scenes sim perception grasp eval)
set(may_include_scenes scenes)
set(may_include_sim sim scenes)
set(may_include_perception perception scenes)
set(may_include_grasp grasp sim scenes)
set(may_include_eval eval grasp perception sim scenes)

# Floors of each folder, lowest first, separated by "|". "." is the folder itself. layer.h of a folder
# is below all of them.
set(floors_scenes "base | image | geometry | camera mesh_io shape_families | bin objects | scenario part_families plugin .")
set(floors_sim "physics convex render sensor | hands drop | .")
set(floors_perception ". cloud | features model segments | crops verify voting | icp networks | completion_networks | completion | candidates | training segment_poses"
  " | crop_methods | estimators")
set(floors_grasp ". place | candidates execute | grippers plan | tolerance cloud | completed | planners")
set(floors_eval "stats | metrics | page | cell shapes frames | trial runtime draw | segments store tolerance explain export | summary bop"
  " | compare sweep train completion success | report budget estimate execution calibrate grasps | replay benchmark"
  " | cli python | reference")

# Third-party header prefix => pattern of the files that may include it. Only Eigen is public.
set(third_party
  "btBullet|BulletCollision|BulletDynamics|LinearMath=>^sim/(physics|hands|convex)/[a-z_]+\\.(cpp|h)$"
  "GL/|EGL/|KHR/=>^sim/render/[a-z_]+\\.(cpp|h)$"
  "torch/|ATen/|c10/=>^perception/(networks|training|completion|completion_networks)/[a-z_]+\\.(cpp|h)$"
  "pcl/=>^perception/(icp/pcl_icp|cloud/normals)\\.cpp$"
  "flann/=>^(perception/features/neighbors|eval/metrics/vertex_tree)\\.cpp$"
  "lz4=>^perception/[a-z_]+/[a-z_]+\\.cpp$"
  "pugixml=>^scenes/mesh_io/xml_elements\\.cpp$"
  "assimp/=>^scenes/mesh_io/(mesh_import|scene_export)\\.cpp$"
  "jpeglib|zlib=>^scenes/image/image_check\\.cpp$"
  "opencv2/=>^(scenes/image/(image_io|number_image)\\.cpp|eval/draw/[a-z_]+\\.(cpp|h)|perception/cloud/color_edges\\.cpp|perception/estimators/ppf_matcher\\.cpp|perception/crop_methods/(hog|linemod)\\.cpp)$"
  "yaml-cpp/=>^scenes/base/(settings(_tree|_names)?\\.cpp|yaml\\.(h|cpp))$"
  "sqlite3=>^eval/store/[a-z_]+\\.(cpp|h)$"
  "boost/=>^(eval/stats/[a-z_]+|scenes/image/image_check)\\.cpp$"
  "nlohmann/=>^(eval/.+\\.(cpp|h)|scenes/mesh_io/gltf_check\\.cpp)$"
  "CLI/=>^eval/cli/.+\\.(cpp|h)$"
  "pybind11/=>^eval/python/[a-z_]+\\.(cpp|h)$"
)

set(problems "")

# floor_of(FOLDER SUB_FOLDER RESULT): the number of the floor, or -1 for an unknown sub-folder.
function(floor_of folder name result)
  string(JOIN "" text ${floors_${folder}})
  string(REPLACE "|" ";" rows "${text}")
  set(floor 0)
  foreach(row ${rows})
    separate_arguments(names UNIX_COMMAND "${row}")
    if(name IN_LIST names)
      set(${result} ${floor} PARENT_SCOPE)
      return()
    endif()
    math(EXPR floor "${floor} + 1")
  endforeach()
  set(${result} -1 PARENT_SCOPE)
endfunction()

# sub_folder_of(PATH RESULT): "camera" of scenes/camera/footprint.h, "." of scenes/scene.h.
function(sub_folder_of path result)
  if(path MATCHES "^[^/]+/([^/]+)/")
    set(${result} ${CMAKE_MATCH_1} PARENT_SCOPE)
  else()
    set(${result} . PARENT_SCOPE)
  endif()
endfunction()

foreach(folder ${folders})
  file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/${folder}/*.h ${ROOT}/${folder}/*.cpp)
  foreach(file ${files})
    sub_folder_of(${file} own)
    floor_of(${folder} ${own} own_floor)
    if(own_floor EQUAL -1 AND NOT file STREQUAL "${folder}/layer.h")
      string(APPEND problems "${file}: unknown sub-folder ${own}; give it a floor in tests/check_includes.cmake\n")
    endif()
    file(STRINGS ${ROOT}/${file} lines REGEX "^#include")
    foreach(line ${lines})
      if(NOT line MATCHES "^#include [<\"]([^>\"]+)[>\"]")
        continue()
      endif()
      set(header ${CMAKE_MATCH_1})
      foreach(target ${folders})
        if(header MATCHES "^${target}/" AND NOT target IN_LIST may_include_${folder})
          string(APPEND problems "${file} includes ${header}: ${folder} may not include ${target}\n")
        endif()
      endforeach()
      if(header MATCHES "^${folder}/" AND NOT header STREQUAL "${folder}/layer.h")
        sub_folder_of(${header} other)
        floor_of(${folder} ${other} other_floor)
        if(NOT other STREQUAL own AND NOT other_floor LESS own_floor)
          string(APPEND problems "${file} includes ${header}: ${own} may not include ${other}\n")
        endif()
      endif()
      # Estimators must not have access to ground truth.
      if(folder STREQUAL perception AND header MATCHES "^scenes/scene\\.h$")
        string(APPEND problems "${file} includes ${header}: perception may not include ground truth\n")
      endif()
      foreach(row ${third_party})
        string(REGEX MATCH "^(.*)=>(.*)$" unused "${row}")
        set(prefix "${CMAKE_MATCH_1}")
        set(allowed "${CMAKE_MATCH_2}")
        if(header MATCHES "^(${prefix})" AND NOT file MATCHES "${allowed}")
          string(APPEND problems "${file} includes ${header}: allowed only in ${allowed}\n")
        endif()
      endforeach()
    endforeach()
  endforeach()
endforeach()

if(problems)
  # FATAL_ERROR wraps its text; NOTICE keeps each problem on one line.
  message(NOTICE "${problems}")
  message(FATAL_ERROR "The files above break a rule of tests/check_includes.cmake.")
endif()
