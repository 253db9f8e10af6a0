# Targets of an installed vademecum: vademecum::vademecum (static) and vademecum::shared.
get_filename_component(vademecum_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
find_package(Threads REQUIRED)
if(NOT TARGET vademecum::vademecum)
  add_library(vademecum::vademecum STATIC IMPORTED)
  set_target_properties(vademecum::vademecum PROPERTIES
    IMPORTED_LOCATION "${vademecum_prefix}/lib/libvademecum.a"
    INTERFACE_INCLUDE_DIRECTORIES "${vademecum_prefix}/include")
  target_link_libraries(vademecum::vademecum INTERFACE Threads::Threads ${CMAKE_DL_LIBS} m)
  add_library(vademecum::shared SHARED IMPORTED)
  set_target_properties(vademecum::shared PROPERTIES
    IMPORTED_LOCATION "${vademecum_prefix}/lib/libvademecum.so"
    IMPORTED_NO_SONAME TRUE
    INTERFACE_INCLUDE_DIRECTORIES "${vademecum_prefix}/include")
endif()
set(vademecum_FOUND TRUE)
