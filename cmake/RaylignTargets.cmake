# raylign_add_module(name SOURCES … PUBLIC … PRIVATE …)
#   One static library per folder of cpp/raylign. PUBLIC names the modules it may include (the layer
#   rule of docs/conventions.md) and the third-party targets its headers need.
function(raylign_add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target raylign_${name})
  if(ARG_SOURCES)
    add_library(${target} STATIC ${ARG_SOURCES})
    target_include_directories(${target} PUBLIC
      "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/cpp>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
    target_compile_features(${target} PUBLIC cxx_std_17)
    target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
    raylign_compile_options(${target})
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE
      "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/cpp>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
    target_compile_features(${target} INTERFACE cxx_std_17)
    target_link_libraries(${target} INTERFACE ${ARG_PUBLIC})
  endif()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  add_library(raylign::${name} ALIAS ${target})
  set_property(GLOBAL APPEND PROPERTY RAYLIGN_MODULES ${target})
endfunction()

# Warnings, sanitizers: PRIVATE, so that users of the installed package keep their own.
function(raylign_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
    $<$<BOOL:${RAYLIGN_WERROR}>:-Werror>)
  if(RAYLIGN_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${RAYLIGN_SANITIZE} -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${RAYLIGN_SANITIZE})
  endif()
endfunction()

# raylign_add_test(module file.cpp [LABELS unit|slow|data] [LINK …]): one gtest binary named
# <module>_<file>, its cases listed by ctest one by one.
function(raylign_add_test module source)
  cmake_parse_arguments(ARG "" "" "LABELS;LINK" ${ARGN})
  get_filename_component(stem ${source} NAME_WE)
  set(target ${module}_${stem})
  add_executable(${target} ${module}/${source})
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/cpp")
  target_link_libraries(${target} PRIVATE raylign_${module} ${ARG_LINK} GTest::gtest_main)
  target_compile_definitions(${target} PRIVATE
    RAYLIGN_DATA_DIR="${PROJECT_SOURCE_DIR}/data" RAYLIGN_SHARED_DATA_DIR="${PROJECT_SOURCE_DIR}/../shared/data")
  raylign_compile_options(${target})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  gtest_discover_tests(${target} TEST_PREFIX "${module}/" PROPERTIES LABELS "${ARG_LABELS}"
                       DISCOVERY_TIMEOUT 60)
endfunction()
