# Run after _core is linked: <build>/python/raylign becomes the importable package, the .py files as
# links into the source tree, so that `PYTHONPATH=<build>/python pytest` needs no installation.
file(GLOB entries RELATIVE "${SOURCE}" "${SOURCE}/*")
file(GLOB links "${DESTINATION}/*")
foreach(link ${links})
  if(IS_SYMLINK "${link}")
    file(REMOVE "${link}")
  endif()
endforeach()
foreach(entry ${entries})
  if(NOT entry STREQUAL "__pycache__")
    file(CREATE_LINK "${SOURCE}/${entry}" "${DESTINATION}/${entry}" SYMBOLIC)
  endif()
endforeach()
