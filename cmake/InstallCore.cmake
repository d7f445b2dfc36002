# What `cmake --install` puts in place for programs that use core as a library: the public headers,
# the archive, a CMake package (find_package(geodesic), target geodesic::core) and a pkg-config
# file. Included by core/CMakeLists.txt.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# All else in core/ is private, and may change at any time.
set(GEODESIC_PUBLIC_HEADERS
  # what everything is made of
  base/cancel.h base/error.h base/memory_budget.h base/shared_array.h base/team.h
  base/tolerances.h base/vec3.h
  # a mesh, prepared once
  mesh/mesh.h mesh/shapes.h mesh/triangle_soup.h
  surface/adjacency.h surface/face_record.h surface/point.h surface/triangulation.h
  surface/unfolded_apex.h
  # distances
  field/field.h field/method.h field/vertex_distances.h
  solve/distances.h solve/farthest_points.h solve/pair_search.h solve/solve_field.h
  solve/solve_scratch.h
  # paths and lines
  paths/isolines.h paths/join_paths.h paths/path.h paths/trace_path.h
  straighten/refine_path.h straighten/shorten_path.h straighten/straightest_geodesic.h
  # from space to the surface
  locate/closest_point.h)

set_target_properties(geodesic_core PROPERTIES EXPORT_NAME core OUTPUT_NAME geodesic)
target_include_directories(geodesic_core INTERFACE
                           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
install(TARGETS geodesic_core EXPORT geodesicTargets COMPONENT geodesic
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})

# Headers include each other as core/...: to others that is geodesic/...
install(CODE "
  set(source \"${CMAKE_CURRENT_SOURCE_DIR}\")
  set(include \"${CMAKE_INSTALL_INCLUDEDIR}\")
  set(headers \"${GEODESIC_PUBLIC_HEADERS}\")" COMPONENT geodesic)
install(SCRIPT ${CMAKE_CURRENT_LIST_DIR}/install_headers.cmake COMPONENT geodesic)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/geodesic)
install(EXPORT geodesicTargets NAMESPACE geodesic:: DESTINATION ${package} COMPONENT geodesic)
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/geodesicConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/geodesicConfig.cmake
  INSTALL_DESTINATION ${package})
write_basic_package_version_file(
  ${CMAKE_CURRENT_BINARY_DIR}/geodesicConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/geodesicConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/geodesicConfigVersion.cmake
        DESTINATION ${package} COMPONENT geodesic)

# Relative to where the file lies, so that the installed tree can be moved.
set(embree_library "")
if(GEODESIC_USE_EMBREE)
  set(embree_library "-lembree${EMBREE_VERSION_MAJOR}")
endif()
file(RELATIVE_PATH prefix_from_pc /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${CMAKE_CURRENT_LIST_DIR}/geodesic.pc.in ${CMAKE_CURRENT_BINARY_DIR}/geodesic.pc
               @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/geodesic.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT geodesic)
