# cmake -DROOT=<source folder> -DOUT=<header> -P HashHeaders.cmake: writes the hash over all headers that are installed.
# The file is left alone if nothing changed, so that nothing is compiled again.
cmake_minimum_required(VERSION 3.24)
file(GLOB_RECURSE headers RELATIVE ${ROOT} ${ROOT}/core/*.h ${ROOT}/record/*.h ${ROOT}/sim/*.h ${ROOT}/cell/*.h ${ROOT}/app/*.h)
list(SORT headers)
set(text)
foreach(header ${headers})
  file(SHA256 ${ROOT}/${header} hash)
  string(APPEND text "${header} ${hash}\n")
endforeach()
string(SHA256 hash "${text}")
string(SUBSTRING ${hash} 0 16 hash)
set(content "#pragma once

/// Hash over all headers that are installed; made by the build (cmake/HashHeaders.cmake).
#define TAKT_INTERFACE_HASH \"${hash}\"
")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT content STREQUAL "${before}")
  file(WRITE ${OUT} "${content}")
endif()
