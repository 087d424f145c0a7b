# evograsp_room(NAME LIBRARIES...): the static library of one room, from every source in its folder.
# A source named main.cpp is left to the room's program.
function(evograsp_room name)
  file(GLOB sources CONFIGURE_DEPENDS *.cpp *.h)
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  add_library(evograsp_${name} STATIC ${sources})
  target_link_libraries(evograsp_${name} PUBLIC evograsp_flags ${ARGN})
  set_target_properties(evograsp_${name} PROPERTIES LINKER_LANGUAGE CXX)
endfunction()

# evograsp_program(NAME ROOM): a program from the main.cpp of the current folder and its room.
function(evograsp_program name room)
  add_executable(${name} main.cpp)
  target_link_libraries(${name} PRIVATE evograsp_${room} ${ARGN})
  install(TARGETS ${name} RUNTIME DESTINATION bin)
endfunction()

# evograsp_tests(ROOM LIBRARIES...): one test program a room and label. The label is in the file's name:
#   X_test.cpp -> unit, X_property_test.cpp -> property, X_integration_test.cpp, X_determinism_test.cpp,
#   X_fault_test.cpp
function(evograsp_tests room)
  set(labels unit property integration determinism fault)
  file(GLOB all CONFIGURE_DEPENDS ${room}/*_test.cpp)
  foreach(label ${labels})
    set(sources ${all})
    if(label STREQUAL "unit")
      list(FILTER sources EXCLUDE REGEX "_(property|integration|determinism|fault)_test\\.cpp$")
    else()
      list(FILTER sources INCLUDE REGEX "_${label}_test\\.cpp$")
    endif()
    if(sources)
      set(target ${room}_${label}_test)
      add_executable(${target} ${sources})
      target_link_libraries(${target} PRIVATE evograsp_testing ${ARGN})
      add_test(NAME ${room}_${label} COMMAND ${target})
      set_tests_properties(${room}_${label} PROPERTIES LABELS ${label} TIMEOUT 900)
    endif()
  endforeach()
endfunction()
