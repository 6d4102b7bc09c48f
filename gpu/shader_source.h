#pragma once
#include <string>
#include <vector>

namespace foreview {

/// A shader's text, ready for the compiler.
struct ShaderSource {
  std::string text;
  std::vector<std::string> files;  ///< by the source-string number that the compiler's messages carry
};

/// Text of the file `name` of gpu/shaders, embedded at build time or read from the directory given to
/// set_shader_directory(). The first line must be a #version directive; `defines` ("#define N 3\n...") go below it.
/// `#include "name"` takes in another file of the same place, at most once per shader (so that snippets may include
/// what they need, and circles end). #line directives keep lines and files right in the compiler's messages.
/// GraphicsError where a file or the #version line is missing.
[[nodiscard]] ShaderSource load_shader(const std::string& name, const std::string& defines = "");

/// Names of all embedded shaders.
[[nodiscard]] std::vector<std::string> embedded_shader_names();

}  // namespace foreview
