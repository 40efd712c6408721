# Debian 12 packages only. Included by the build and, installed beside it, by the package's meshmserConfig.cmake; hence
# targets that are IMPORTED: the package names them and makes them anew on the machine where it is used.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(embree 3 REQUIRED)

# FLANN's and PCL's own CMake files pull in VTK, Qt and more; the parts used here are named outright.
find_path(FLANN_INCLUDE_DIR flann/flann.hpp REQUIRED)
find_library(FLANN_LIBRARY flann_cpp REQUIRED)
find_library(LZ4_LIBRARY lz4 REQUIRED)
add_library(meshmser_flann INTERFACE IMPORTED)
target_include_directories(meshmser_flann INTERFACE ${FLANN_INCLUDE_DIR})
target_link_libraries(meshmser_flann INTERFACE ${FLANN_LIBRARY} ${LZ4_LIBRARY})

find_path(PCL_INCLUDE_DIR pcl/point_types.h PATH_SUFFIXES pcl-1.13 pcl-1.12 pcl-1.14 REQUIRED)
add_library(meshmser_pcl INTERFACE IMPORTED)
target_include_directories(meshmser_pcl INTERFACE ${PCL_INCLUDE_DIR})
target_link_libraries(meshmser_pcl INTERFACE Eigen3::Eigen)
foreach(part common octree kdtree search sample_consensus filters io)
  find_library(PCL_${part}_LIBRARY pcl_${part} REQUIRED)
  target_link_libraries(meshmser_pcl INTERFACE ${PCL_${part}_LIBRARY})
endforeach()

# CGAL is header-only; its CMake package would set flags for the whole project.
find_path(CGAL_INCLUDE_DIR CGAL/version.h REQUIRED)
find_library(GMP_LIBRARY gmp REQUIRED)
find_library(MPFR_LIBRARY mpfr REQUIRED)
add_library(meshmser_cgal INTERFACE IMPORTED)
target_include_directories(meshmser_cgal INTERFACE ${CGAL_INCLUDE_DIR})
target_compile_options(meshmser_cgal INTERFACE -frounding-math)
target_link_libraries(meshmser_cgal INTERFACE ${GMP_LIBRARY} ${MPFR_LIBRARY} Threads::Threads)
