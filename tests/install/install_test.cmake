# Run by ctest; see CMakeLists.txt for what it is given.
cmake_policy(VERSION 3.25)

# check(WHAT COMMAND...): runs it, fails with its output where it fails, leaves what it prints in `output`.
function(check what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE printed ERROR_VARIABLE messages)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed (${result}):\n${printed}\n${messages}")
  endif()
  set(output "${printed}" PARENT_SCOPE)
endfunction()

function(expect_equal what found expected)
  if(NOT found STREQUAL expected)
    message(FATAL_ERROR "${what}\nfound:\n${found}\nexpected:\n${expected}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_FOLDER})
check("installing" ${CMAKE_COMMAND} --install ${BUILD_FOLDER} --prefix ${WORK_FOLDER}/first)
# What is installed must not remember where it was put.
set(prefix ${WORK_FOLDER}/moved)
file(RENAME ${WORK_FOLDER}/first ${prefix})

foreach(program meshmser meshmser-scan)
  check("${program} --version" ${prefix}/bin/${program} --version)
  if(NOT output MATCHES "${VERSION}")
    message(FATAL_ERROR "${program} --version says '${output}', expected ${VERSION}")
  endif()
endforeach()
check("validating the installed demo" ${prefix}/bin/meshmser validate ${prefix}/share/meshmser/configs/demo.yaml)
check("bash completion" bash -c "source '${prefix}/share/bash-completion/completions/meshmser'
COMP_WORDS=(meshmser vali)
COMP_CWORD=1
_meshmser
echo \"\${COMPREPLY[*]}\"")
expect_equal("completion of 'meshmser vali'" "${output}" "validate\n")
file(STRINGS ${prefix}/share/zsh/site-functions/_meshmser first_line LIMIT_COUNT 1)
expect_equal("first line of the zsh completion" "${first_line}" "#compdef meshmser")

file(GLOB package ${prefix}/${LIBRARIES}/cmake/meshmser/*.cmake)
foreach(file IN LISTS package)
  file(READ ${file} text)
  foreach(folder ${SOURCE_FOLDER} ${BUILD_FOLDER} ${WORK_FOLDER})
    string(FIND "${text}" "${folder}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()

file(GLOB_RECURSE headers RELATIVE ${prefix}/include/meshmser ${prefix}/include/meshmser/*.hpp)
if(NOT headers)
  message(FATAL_ERROR "no header below ${prefix}/include/meshmser")
endif()
foreach(header IN LISTS headers)
  file(STRINGS ${prefix}/include/meshmser/${header} includes REGEX "^#include \"")
  foreach(line IN LISTS includes)
    string(REGEX REPLACE "^#include \"([^\"]*)\".*" "\\1" included "${line}")
    if(NOT EXISTS ${prefix}/include/meshmser/${included})
      message(FATAL_ERROR "${header} includes ${included}, which is not installed")
    endif()
  endforeach()
endforeach()

# build(NAME SOURCE): the project in SOURCE, against what is installed, in WORK_FOLDER/NAME.
function(build name source)
  check("configuring ${name}" ${CMAKE_COMMAND} -S ${source} -B ${WORK_FOLDER}/${name} -G ${GENERATOR}
        -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_FLAGS=${FLAGS}
        -D CMAKE_BUILD_TYPE=${BUILD_TYPE})
  check("building ${name}" ${CMAKE_COMMAND} --build ${WORK_FOLDER}/${name})
endfunction()

build(consumer ${SOURCE_FOLDER}/docs/example)
check("running the consumer" ${WORK_FOLDER}/consumer/regions_of_steps)
# By hand: a terrace is the squares of the grid whose four corners stand on it, 10 x 10, 6 x 8 with one side of 8 at the
# rim, and 4 x 4.
expect_equal("what the consumer prints" "${output}" "\
region 1 of area 100: border of 40 along a level, 0 along the rim
region 2 of area 48: border of 20 along a level, 8 along the rim
region 3 of area 16: border of 16 along a level, 0 along the rim
")
# It is to stay an example.
file(READ ${SOURCE_FOLDER}/docs/example/main.cpp text)
string(REGEX MATCHALL "\n" line_ends "${text}")
list(LENGTH line_ends num_lines)
if(num_lines GREATER 40)
  message(FATAL_ERROR "docs/example/main.cpp has ${num_lines} lines, more than 40")
endif()

if(PYTHON)
  check("running the Python example" ${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/${PYTHON_FOLDER}
        ${PYTHON} ${SOURCE_FOLDER}/docs/example/regions_of_mesas.py)
  if(NOT output MATCHES "region 1: upper, area 365,")
    message(FATAL_ERROR "the Python example prints\n${output}")
  endif()
endif()

# Every header in one source, every library linked whole: a dependency that the package forgets shows here.
file(GLOB libraries ${prefix}/${LIBRARIES}/libmeshmser_*.a)
list(TRANSFORM libraries REPLACE "^.*/libmeshmser_(.*)\\.a$" "meshmser::\\1" OUTPUT_VARIABLE rooms)
list(TRANSFORM libraries PREPEND "\"")
list(TRANSFORM libraries APPEND "\"")
list(JOIN libraries " " libraries)
list(JOIN rooms " " rooms)
file(WRITE ${WORK_FOLDER}/whole/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(whole LANGUAGES C CXX)
find_package(meshmser ${VERSION} EXACT REQUIRED)
add_executable(whole main.cpp)
target_link_options(whole PRIVATE -Wl,--whole-archive ${libraries} -Wl,--no-whole-archive)
target_link_libraries(whole PRIVATE ${rooms})
")
list(TRANSFORM headers PREPEND "#include \"")
list(TRANSFORM headers APPEND "\"\n")
string(CONCAT includes ${headers})
file(WRITE ${WORK_FOLDER}/whole/main.cpp "${includes}\nint main() {}\n")
build(linked ${WORK_FOLDER}/whole)
