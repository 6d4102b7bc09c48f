# cmake -DOUTPUT=embedded_shaders.cpp -DFILES=a.glsl;b.glsl -P embed_shaders.cmake
# Writes the table that gpu/shader_source.cpp declares. Bytes as hex escapes, so that nothing in a shader needs quoting.
set(entries "")
foreach(file ${FILES})
  get_filename_component(name ${file} NAME)
  file(READ ${file} hex HEX)
  string(LENGTH "${hex}" digits)
  math(EXPR size "${digits} / 2")
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${hex}")
  string(APPEND entries "    {\"${name}\", std::string_view(\"${bytes}\", ${size})},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made from gpu/shaders by embed_shaders.cmake.
#include <string_view>
#include <utility>

namespace foreview::gpu_detail {
extern const std::pair<std::string_view, std::string_view> embedded_shaders[];
extern const unsigned embedded_shader_count;
const std::pair<std::string_view, std::string_view> embedded_shaders[] = {
${entries}    {\"\", \"\"},
};
const unsigned embedded_shader_count = sizeof(embedded_shaders) / sizeof(embedded_shaders[0]) - 1;
}  // namespace foreview::gpu_detail
")
