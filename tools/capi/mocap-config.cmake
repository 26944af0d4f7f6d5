# find_package(mocap): the targets mocap::mocap, the shared library, and mocap::static, with the header's folder.

get_filename_component(_mocap_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET mocap::mocap AND EXISTS "${_mocap_prefix}/lib/libmocap.so.0")
    add_library(mocap::mocap SHARED IMPORTED)
    set_target_properties(
        mocap::mocap
        PROPERTIES IMPORTED_LOCATION "${_mocap_prefix}/lib/libmocap.so.0"
                   IMPORTED_SONAME libmocap.so.0
                   INTERFACE_INCLUDE_DIRECTORIES "${_mocap_prefix}/include")
endif()

if(NOT TARGET mocap::static AND EXISTS "${_mocap_prefix}/lib/libmocap.a")
    add_library(mocap::static STATIC IMPORTED)
    set_target_properties(
        mocap::static
        PROPERTIES IMPORTED_LOCATION "${_mocap_prefix}/lib/libmocap.a"
                   INTERFACE_INCLUDE_DIRECTORIES "${_mocap_prefix}/include"
                   INTERFACE_LINK_LIBRARIES "pthread;dl;m")
endif()

if(NOT TARGET mocap::mocap AND NOT TARGET mocap::static)
    set(mocap_FOUND FALSE)
    set(mocap_NOT_FOUND_MESSAGE "there is no libmocap in ${_mocap_prefix}/lib: run tools/capi/install ${_mocap_prefix}")
endif()

unset(_mocap_prefix)
