# A layer is a folder: takt_layer(<folder with / as _> <targets it may use...> [IN_CYCLE] [ALONE <files...>]) makes the
# static library takt_<name> from every .cc in the folder; IN_CYCLE: much of it runs in each cycle. ROOMS <folders...>: its
# subfolders, from the bottom up, which belong to the same library (lint checks their order). Its tests lie in tests/<folder>,
# its benchmarks in bench/<folder>.

# Most of the time of a compiler here goes into the headers (a file of 200 lines: 1 s to load the precompiled header,
# 3 s for JSON, 1 s for itself), so several files of a folder are compiled as one; docs/benchmarks.md has what
# that saves.
# Names in unnamed namespaces are therefore unique within a folder. An edit compiles its whole batch, up to 20 s; for
# work on one folder -DTAKT_BATCH=1 (preset dev) compiles each file by itself.
set(TAKT_BATCH 12 CACHE STRING "Files of a folder that are compiled together; 1: each by itself")

# takt_batches(<variable> <target> <sources...> [ALONE <files...>]): what to compile for these sources. A batch includes
# by paths from the root and not by absolute ones, so that every clone shares the compiler's cache.
function(takt_batches variable target)
  cmake_parse_arguments(BATCH "" "" "ALONE" ${ARGN})
  set(sources ${BATCH_UNPARSED_ARGUMENTS})
  if(TAKT_BATCH LESS 2)
    set(${variable} ${sources} PARENT_SCOPE)
    return()
  endif()
  set(result)
  foreach(file ${BATCH_ALONE})
    if(NOT ${CMAKE_CURRENT_SOURCE_DIR}/${file} IN_LIST sources)
      message(FATAL_ERROR "${target}: ALONE names ${file}, which is not in ${CMAKE_CURRENT_SOURCE_DIR}")
    endif()
    list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    list(APPEND result ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  list(SORT sources)
  set(number 0)
  while(sources)
    list(SUBLIST sources 0 ${TAKT_BATCH} batch)
    list(REMOVE_ITEM sources ${batch})
    set(text "// Made by the build (cmake/TaktLayers.cmake): files that are compiled together.\n")
    foreach(source ${batch})
      file(RELATIVE_PATH path ${CMAKE_SOURCE_DIR} ${source})
      string(APPEND text "#include \"${path}\"\n")
    endforeach()
    set(file ${CMAKE_BINARY_DIR}/batches/${target}_${number}.cc)
    file(CONFIGURE OUTPUT ${file} CONTENT "${text}" @ONLY)
    list(APPEND result ${file})
    math(EXPR number "${number} + 1")
  endwhile()
  set(${variable} ${result} PARENT_SCOPE)
endfunction()

# What a precompiled header depends on, for ccache: the header itself, the compiler, the libraries in it.
function(takt_pch_checksum target header)
  get_target_property(options ${target} COMPILE_OPTIONS)
  file(SHA256 ${header} checksum)
  file(SHA256 ${CMAKE_SOURCE_DIR}/cmake/pch.h base)
  set(text "${checksum} ${base} ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION} ${CMAKE_CXX_FLAGS} ${CMAKE_BUILD_TYPE} \
${TAKT_SANITIZE} ${options} ${Eigen3_VERSION} ${fmt_VERSION} ${nlohmann_json_VERSION} ${GTest_VERSION}")
  foreach(system_header /usr/include/eigen3/Eigen/Core /usr/include/nlohmann/json.hpp /usr/include/fmt/format.h)
    if(EXISTS ${system_header})
      file(SHA256 ${system_header} checksum)
      string(APPEND text " ${checksum}")
    endif()
  endforeach()
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/cmake_pch.hxx.gch.sum "${text}\n")
endfunction()

# takt_pch_library(<name> <options...>): a precompiled header of all code that is compiled with these options. GCC takes
# its parameters from the header, so code with others needs another one.
function(takt_pch_library name)
  add_library(${name} OBJECT ${CMAKE_SOURCE_DIR}/cmake/pch.cc)
  target_link_libraries(${name} PUBLIC Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_compile_options(${name} PRIVATE ${ARGN})
  target_precompile_headers(${name} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/pch.h)
  takt_pch_checksum(${name} ${CMAKE_SOURCE_DIR}/cmake/pch.h)
endfunction()

# GCC lets a small file grow without limit by inlining, a large one by two fifths. A batch is large, so code that runs
# in the cycle would lose what its files alone had: a tenth of the time of a cycle and of a plan (docs/benchmarks.md).
set(TAKT_CYCLE_OPTIONS)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(TAKT_CYCLE_OPTIONS "SHELL:--param inline-unit-growth=400")
endif()

# One precompiled header for the code of the cycle, one for all other code, one more for tests.
takt_pch_library(takt_pch)
takt_pch_library(takt_cycle_pch ${TAKT_CYCLE_OPTIONS})

function(takt_layer name)
  cmake_parse_arguments(LAYER "IN_CYCLE" "" "ALONE;ROOMS" ${ARGN})
  set(libraries ${LAYER_UNPARSED_ARGUMENTS})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  foreach(room ${LAYER_ROOMS})
    file(GLOB room_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${room}/*.cc)
    list(APPEND sources ${room_sources})
  endforeach()
  set(target takt_${name})
  if(NOT sources)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE ${libraries} Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
    return()
  endif()
  takt_batches(sources ${target} ${sources} ALONE ${LAYER_ALONE})
  add_library(${target} STATIC ${sources})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
  target_link_libraries(${target} PUBLIC ${libraries} Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  if(LAYER_IN_CYCLE)
    target_compile_options(${target} PRIVATE ${TAKT_CYCLE_OPTIONS})
    target_precompile_headers(${target} REUSE_FROM takt_cycle_pch)
  else()
    target_precompile_headers(${target} REUSE_FROM takt_pch)
  endif()
endfunction()

# takt_link_whole(<target> <libraries...>): all members of these static libraries, used or not. CMake's own
# $<LINK_LIBRARY:WHOLE_ARCHIVE,...> names a library twice where others need it too, and then every symbol is double.
function(takt_link_whole target)
  set(files)
  foreach(library ${ARGN})
    string(APPEND files " $<TARGET_FILE:${library}>")
  endforeach()
  target_link_options(${target} PRIVATE "SHELL:-Wl,--push-state,--whole-archive${files} -Wl,--pop-state")
  target_link_libraries(${target} PRIVATE ${ARGN})
endfunction()

# takt_tests(<folder with / as _> <libraries...> [FAST] [ALONE <files...>]): one test program from every .cc in this
# folder. FAST: it takes a few seconds at most, and belongs to './takt test --fast'.
function(takt_tests name)
  cmake_parse_arguments(LAYER "FAST" "" "ALONE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  if(NOT sources)
    return()
  endif()
  set(target test_${name})
  takt_batches(sources ${target} ${sources} ALONE ${LAYER_ALONE})
  add_executable(${target} ${sources})
  target_include_directories(${target} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE ${LAYER_UNPARSED_ARGUMENTS} takt_test_support GTest::gmock GTest::gtest_main)
  target_precompile_headers(${target} REUSE_FROM takt_test_pch)
  add_dependencies(${target} takt_meshes)  # a URDF whose meshes are missing is refused
  add_test(NAME ${name} COMMAND ${target} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
  if(LAYER_FAST)
    set_tests_properties(${name} PROPERTIES LABELS fast)
  endif()
endfunction()
