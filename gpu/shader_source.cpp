#include "foreview/gpu/shader_source.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <regex>
#include <sstream>
#include <string_view>
#include <utility>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/errors.h"

namespace foreview {

namespace gpu_detail {
extern const std::pair<std::string_view, std::string_view> embedded_shaders[];
extern const unsigned embedded_shader_count;
}  // namespace gpu_detail

namespace {

std::mutex directory_mutex;
std::string& directory_setting() {
  static std::string directory;
  return directory;
}

std::string read_shader_file(const std::string& name) {
  std::string directory;
  {
    const std::lock_guard lock(directory_mutex);
    directory = directory_setting();
  }
  if (!directory.empty()) {
    const std::filesystem::path path = std::filesystem::path(directory) / name;
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw GraphicsError("shader " + path.string() + " cannot be read");
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }
  for (unsigned i = 0; i < gpu_detail::embedded_shader_count; ++i) {
    if (gpu_detail::embedded_shaders[i].first == name) return std::string(gpu_detail::embedded_shaders[i].second);
  }
  throw GraphicsError("there is no shader " + name + " in gpu/shaders");
}

std::string line_directive(int line, std::size_t file) {
  return "#line " + std::to_string(line) + " " + std::to_string(file) + "\n";
}

void append_file(const std::string& name, const std::string& defines, ShaderSource& source) {
  const bool outermost = source.files.empty();
  const std::size_t number = source.files.size();
  source.files.push_back(name);
  std::istringstream stream(read_shader_file(name));
  if (!outermost) source.text += line_directive(1, number);
  static const std::regex include_pattern(R"re(^\s*#\s*include\s+"([^"]+)"\s*(//.*)?$)re");
  static const std::regex version_pattern(R"re(^\s*#\s*version\s.*$)re");
  std::string line;
  for (int line_number = 1; std::getline(stream, line); ++line_number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::smatch match;
    if (outermost && line_number == 1) {
      if (!std::regex_match(line, version_pattern)) {
        throw GraphicsError("shader " + name + " must begin with a #version line");
      }
      source.text += line;
      source.text += '\n';
      source.text += defines;
      if (!defines.empty() && defines.back() != '\n') source.text += "\n";
      source.text += "#line 2 0\n";
    } else if (std::regex_match(line, match, include_pattern)) {
      const std::string included = match[1];
      if (std::find(source.files.begin(), source.files.end(), included) == source.files.end()) {
        append_file(included, "", source);
      }
      source.text += line_directive(line_number + 1, number);
    } else {
      source.text += line;
      source.text += '\n';
    }
  }
  if (outermost && source.text.empty()) throw GraphicsError("shader " + name + " must begin with a #version line");
}

}  // namespace

void set_shader_directory(const char* directory) {
  const std::lock_guard lock(directory_mutex);
  directory_setting() = directory;
}

ShaderSource load_shader(const std::string& name, const std::string& defines) {
  ShaderSource source;
  append_file(name, defines, source);
  return source;
}

std::vector<std::string> embedded_shader_names() {
  std::vector<std::string> names;
  for (unsigned i = 0; i < gpu_detail::embedded_shader_count; ++i) {
    names.emplace_back(gpu_detail::embedded_shaders[i].first);
  }
  return names;
}

}  // namespace foreview
