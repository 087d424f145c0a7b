# evograsp_embed(TARGET NAME ROOT FILE...): files inside the program.
#
# Adds to TARGET a header "embedded/NAME.h" that declares
#   namespace evograsp::embedded { std::span<const File> NAME(); }
# (see common/embedded.h). Each file's name is its path relative to ROOT; files are in the order given. The
# bytes go in by the assembler's .incbin: no size is too large and nothing is converted.
function(evograsp_embed target name root)
  set(assembly "")
  set(symbols "")
  set(entries "")
  set(index 0)
  foreach(file ${ARGN})
    get_filename_component(path ${file} ABSOLUTE)
    file(RELATIVE_PATH key ${root} ${path})
    set(symbol evograsp_${name}_${index})
    string(APPEND assembly "    \"${symbol}: .incbin \\\"${path}\\\"\\n\"\n    \"${symbol}_end: .byte 0\\n\"\n")
    string(APPEND symbols "extern const char ${symbol}[], ${symbol}_end[];\n")
    string(APPEND entries "      {\"${key}\", {${symbol}, static_cast<std::size_t>(${symbol}_end - ${symbol})}},\n")
    math(EXPR index "${index} + 1")
    list(APPEND paths ${path})
  endforeach()
  set(folder ${PROJECT_BINARY_DIR}/embedded)
  file(CONFIGURE OUTPUT ${folder}/${name}.h @ONLY CONTENT [[
#pragma once
#include "common/embedded.h"

namespace evograsp::embedded {
std::span<const File> @name@();
}
]])
  file(CONFIGURE OUTPUT ${folder}/${name}.cpp @ONLY CONTENT [[
#include "embedded/@name@.h"

__asm__(
    ".pushsection .rodata\n"
@assembly@    ".popsection\n");
extern "C" {
@symbols@}

std::span<const evograsp::embedded::File> evograsp::embedded::@name@() {
  static const File files[] = {
@entries@  };
  return files;
}
]])
  set_property(SOURCE ${folder}/${name}.cpp PROPERTY OBJECT_DEPENDS ${paths})
  target_sources(${target} PRIVATE ${folder}/${name}.cpp)
endfunction()
