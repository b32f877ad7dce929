# raylign_header_check: one translation unit per public header that includes it first and nothing
# else, so that a header which leans on another include does not compile.
file(GLOB_RECURSE _headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}/cpp"
     "${PROJECT_SOURCE_DIR}/cpp/raylign/*.h")
set(_sources)
foreach(_header ${_headers})
  set(_source "${PROJECT_BINARY_DIR}/header_check/${_header}.cpp")
  file(CONFIGURE OUTPUT "${_source}" CONTENT "#include \"@_header@\"\n#include \"@_header@\"\n" @ONLY)
  list(APPEND _sources "${_source}")
endforeach()
add_library(raylign_header_check OBJECT ${_sources})
target_link_libraries(raylign_header_check PRIVATE raylign_raylign)
target_include_directories(raylign_header_check PRIVATE "${PROJECT_SOURCE_DIR}/cpp")
raylign_compile_options(raylign_header_check)
target_compile_options(raylign_header_check PRIVATE -O0)
