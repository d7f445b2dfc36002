# The libraries that core is built on.
find_package(tl-expected REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)  # headers alone

# Embree 3 (Debian 12) or 4 (Debian 13), which differ in the header's folder and in a few calls;
# GEODESIC_EMBREE tells the code which it is.
if(GEODESIC_USE_EMBREE)
  find_package(embree)
  if(NOT embree_FOUND)
    message(FATAL_ERROR "No Embree: install it (Debian: libembree-dev), or build with "
                        "-DGEODESIC_USE_EMBREE=OFF, which finds points in space more slowly")
  endif()
  message(STATUS "Embree ${EMBREE_VERSION}")
endif()
