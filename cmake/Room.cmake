# One target a room, so that the link graph says who may include whom.
#
# meshmser_room(NAME DIRECTORY [PUBLIC targets] [PRIVATE targets])
#   static library meshmser_NAME (alias meshmser::NAME) of every .cpp directly in DIRECTORY but
#   stage.cpp, main.cpp and, in a stage, *_command.cpp.
# meshmser_stage(NAME [PRIVATE targets])
#   object library meshmser_stage_NAME of stages/NAME/stage.cpp and stages/NAME/*_command.cpp:
#   objects, because a stage or command that registers itself would vanish from a static library.
# meshmser_link_stages(TARGET)
#   every stage into TARGET; to be called after the stages are added.
# meshmser_test(NAME DIRECTORY [LABELS labels] [LIBRARIES targets])
#   one GoogleTest program of every *_test.cpp in DIRECTORY.

include(GNUInstallDirs)

add_library(meshmser_flags INTERFACE)
add_library(meshmser::flags ALIAS meshmser_flags)
target_compile_features(meshmser_flags INTERFACE cxx_std_20)
target_compile_options(meshmser_flags INTERFACE
  $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wshadow> $<BUILD_INTERFACE:-Wnon-virtual-dtor>
  # GCC 12 warns of overlapping copies in its own std::string (GCC bug 105651).
  $<BUILD_INTERFACE:-Wno-restrict> -ffp-contract=off)
if(MESHMSER_WERROR)
  target_compile_options(meshmser_flags INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(MESHMSER_NATIVE)
  # Whoever links the rooms too: Eigen's alignment depends on it.
  target_compile_options(meshmser_flags INTERFACE -march=native
    # GCC 12 warns of its own AVX-512 intrinsics (GCC bug 105593) and of Eigen's loops over wide packets that never run.
    $<BUILD_INTERFACE:-Wno-maybe-uninitialized> $<BUILD_INTERFACE:-Wno-array-bounds>
    $<BUILD_INTERFACE:-Wno-stringop-overread>)
endif()
target_include_directories(meshmser_flags INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/meshmser>)
set_target_properties(meshmser_flags PROPERTIES EXPORT_NAME flags)

set_property(GLOBAL PROPERTY MESHMSER_ROOMS meshmser_flags)
set_property(GLOBAL PROPERTY MESHMSER_STAGES "")

function(meshmser_room name directory)
  cmake_parse_arguments(ROOM "" "" "PUBLIC;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${directory}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/(stage|main)\\.cpp$|/stages/[^/]+/[a-z_]+_command\\.cpp$")
  if(sources)
    add_library(meshmser_${name} STATIC ${sources})
    set(scope PUBLIC)
    target_link_libraries(meshmser_${name} PRIVATE ${ROOM_PRIVATE})
    set_target_properties(meshmser_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  else()
    add_library(meshmser_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_link_libraries(meshmser_${name} ${scope} meshmser_flags ${ROOM_PUBLIC})
  set_target_properties(meshmser_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(meshmser::${name} ALIAS meshmser_${name})
  set_property(GLOBAL APPEND PROPERTY MESHMSER_ROOMS meshmser_${name})
endfunction()

function(meshmser_stage name)
  cmake_parse_arguments(STAGE "" "" "PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/stages/${name}/stage.cpp
       ${PROJECT_SOURCE_DIR}/stages/${name}/*_command.cpp)
  add_library(meshmser_stage_${name} OBJECT ${sources})
  target_link_libraries(meshmser_stage_${name} PUBLIC meshmser::stage meshmser::${name} ${STAGE_PRIVATE})
  set_target_properties(meshmser_stage_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  set_property(GLOBAL APPEND PROPERTY MESHMSER_STAGES ${name})
endfunction()

function(meshmser_link_stages target)
  get_property(stages GLOBAL PROPERTY MESHMSER_STAGES)
  foreach(stage IN LISTS stages)
    target_link_libraries(${target} PRIVATE meshmser_stage_${stage})
  endforeach()
endfunction()

function(meshmser_test name directory)
  cmake_parse_arguments(TEST "" "" "LABELS;LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${directory}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE ${TEST_LIBRARIES} meshmser::flags GTest::gtest GTest::gmock GTest::gtest_main)
  # Only where it is read: an absolute path in every command would keep a compiler cache from serving another checkout.
  foreach(source IN LISTS sources)
    file(STRINGS ${source} reads_source_folder REGEX MESHMSER_SOURCE_DIR LIMIT_COUNT 1)
    if(reads_source_folder)
      set_property(SOURCE ${source} APPEND PROPERTY COMPILE_DEFINITIONS MESHMSER_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    endif()
  endforeach()
  if(NOT TEST_LABELS)
    set(TEST_LABELS fast)
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS "${TEST_LABELS}")
endfunction()
