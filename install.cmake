# What `cmake --install` writes: program, assets and presets, and for C++ users the libraries, their headers
# and the package that find_package(pickbed) reads.
include(CMakePackageConfigHelpers)
set(assets_folder ${CMAKE_INSTALL_DATADIR}/pickbed/assets)
set(headers_folder ${CMAKE_INSTALL_INCLUDEDIR}/pickbed)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/pickbed)

install(TARGETS pickbed RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY assets/ DESTINATION ${assets_folder})
install(DIRECTORY scenes/presets DESTINATION ${CMAKE_INSTALL_DATADIR}/pickbed)
install(DIRECTORY scenes/plugin/python DESTINATION ${CMAKE_INSTALL_DATADIR}/pickbed FILES_MATCHING PATTERN "*.py")
install(FILES ${CMAKE_BINARY_DIR}/report/page.html DESTINATION ${assets_folder}/report OPTIONAL)

# Headers of the four libraries. Those that need a third-party library other than Eigen are private.
install(DIRECTORY scenes sim perception grasp DESTINATION ${headers_folder}
  FILES_MATCHING PATTERN "*.h"
  PATTERN scenes/presets EXCLUDE
  REGEX "scenes/base/(ids_format|yaml)\\.h$" EXCLUDE
  REGEX "sim/physics/(body_shapes|contact_islands|contact_reuse|pad_geometry|patch_friction|row_solver|warm_contact|warm_joints)\\.h$" EXCLUDE
  REGEX "sim/render/gl_(drawer|functions|objects|programs|readback|targets)\\.h$" EXCLUDE
  REGEX "sim/render/(shadow_map|software_raster)\\.h$" EXCLUDE
  REGEX "perception/networks/(eigen_tensors|fixed_(convolution|layers|sums)|torch_runtime|training_tensors|trunk|wohlhart_layers)\\.h$" EXCLUDE
  REGEX "perception/completion_networks/(completion_net|image_unet|volume_blocks)\\.h$" EXCLUDE)

# Users link the first four targets. They have the same names in the build tree. The others are linked by
# these four.
set(public_targets scenes sim perception grasp)
foreach(name ${public_targets})
  add_library(pickbed::${name} ALIAS pickbed_${name})
endforeach()
target_compile_features(pickbed_scenes INTERFACE cxx_std_20)
foreach(name ${public_targets} perception_geometry perception_networks perception_completion opencv_io opencv_matching torch)
  set_target_properties(pickbed_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS pickbed_${name} EXPORT pickbed ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    INCLUDES DESTINATION ${headers_folder})
endforeach()
install(EXPORT pickbed FILE pickbedTargets.cmake NAMESPACE pickbed:: DESTINATION ${package_folder})

# The package finds the third-party libraries that the static libraries need. The names of the pkg-config
# targets must be those of the top-level CMakeLists.txt.
set(config ${CMAKE_BINARY_DIR}/package/pickbedConfig.cmake)
file(WRITE ${config}.in [=[
@PACKAGE_INIT@
set_and_check(pickbed_ASSETS_DIR @PACKAGE_assets_folder@)
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4)
find_dependency(assimp)
find_dependency(pugixml)
find_dependency(nlohmann_json)
find_dependency(yaml-cpp)
find_dependency(fmt)
find_dependency(JPEG)
find_dependency(ZLIB)
find_dependency(OpenCV 4.6 COMPONENTS core imgproc imgcodecs surface_matching objdetect rgbd)
find_dependency(Torch)
find_dependency(PkgConfig)
pkg_check_modules(bullet REQUIRED QUIET IMPORTED_TARGET bullet-float64)
pkg_check_modules(flann REQUIRED QUIET IMPORTED_TARGET flann)
pkg_check_modules(lz4 REQUIRED QUIET IMPORTED_TARGET liblz4)
pkg_check_modules(pcl REQUIRED QUIET IMPORTED_TARGET pcl_registration pcl_search pcl_kdtree pcl_common)
include(${CMAKE_CURRENT_LIST_DIR}/pickbedTargets.cmake)
check_required_components(pickbed)
]=])
configure_package_config_file(${config}.in ${config}
  INSTALL_DESTINATION ${package_folder} PATH_VARS assets_folder)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/pickbedConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${config} ${CMAKE_BINARY_DIR}/package/pickbedConfigVersion.cmake
  DESTINATION ${package_folder})
